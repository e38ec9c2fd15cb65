"""Figures of docs/accuracy.md."""

import re
import sys

from accuracy_table import foretell, honesty_table, judge, of_all, predictions_table
from figures.curves import exponent as fitted
from figures.curves import is_ahead, overtaking
from figures.studies import curves, exponent, price_of_half, reached, seconds_to, spread, study, theory
from figures.tools import (
    PROGRAM, ROOT, caustica, caustica_json, caustica_lines, digits, finished, machine, paragraphs, run, span, table, typed,
)


def percent(share, places=2):
    return f"{100 * share:.{places}f}"


def honesty():
    """Two minutes."""
    judged = of_all(judge, PROGRAM, ROOT / "out/accuracy")
    outside = [row["scene"] for row in judged if not all(abs(share - aim) <= 0.05 for share, aim in zip(row["within"], (0.9, 0.5)))]
    verdict = f"Outside: {', '.join(outside)}." if outside else "All scenes are inside."
    ratios = [row["error"] / row["true"] for row in judged]
    return paragraphs(
        honesty_table(judged), f"{verdict} The estimate of the whole picture is {span(ratios, '{:.2f}'.format)} times the true error."
    )


def predictions():
    """A minute and a half."""
    told = of_all(foretell, PROGRAM, ROOT / "out/accuracy")
    wrong = {name: max(abs(row[name][0] / row[name][1] - 1) for row in told) for name in ("passes", "seconds")}
    return paragraphs(
        predictions_table(told),
        f"On {machine()}. The worst prediction is wrong by {percent(wrong['passes'], 0)} % of the passes, and by "
        f"{percent(wrong['seconds'], 0)} % of the seconds. The exponent is that of the error at the time of asking.",
    )


# What estimates cost is measured in so many runs of either kind, in turns.
RUNS = 2
RENDERS = ("course_diffuse", "course_water", "cornell_b")


def share_of_estimates(scene, passes, *options):
    """Of the seconds of a render, what estimating its error took."""
    lines = caustica_lines(f"render data/{scene}.toml --passes {passes} --photons 1e5 --json -", *options)
    seconds = sum(line["phases"]["errors"] + line.get("error", {}).get("seconds", 0.0) for line in lines)
    return seconds / lines[-1]["seconds_in_all"]


def estimates():
    """A minute and a half."""
    rows, means = [], []
    for scene in RENDERS:
        shares = [(share_of_estimates(scene, 64), share_of_estimates(scene, 64, "--layers")) for _ in range(RUNS)]
        means.append([sum(column) / RUNS for column in zip(*shares)])
        rows.append([scene, *(percent(mean, 1) for mean in means[-1])])
    long = share_of_estimates("course_diffuse", 600, "--layers")
    most = [max(column) for column in zip(*means)]
    shown = "render data/course_water.toml --passes 64 --photons 1e5 --json out/passes.jsonl"
    return paragraphs(
        table(["scene", "share of the estimates (%)", "with `--layers` (%)"], rows),
        f"On {machine()}, 64 passes, means of {RUNS} runs. Estimates take at most {percent(most[0], 1)} % of a render, with layers "
        f"{percent(most[1], 1)} %; in 600 passes of `course_diffuse` they take {percent(long, 1)} % with layers.",
        typed(shown, f"{shown} --layers"),
    )


SECONDS, REFERENCE_SECONDS = 20, 60
CAUSTIC = "data/cornell_b.toml"
LIGHT = [
    f"reference {CAUSTIC} --method light --spp 1000000 --time {REFERENCE_SECONDS} --seed {seed} -o out/light_{seed}.exr"
    for seed in (8, 9)
]
RIVALS = {
    "path tracing": f"reference {CAUSTIC} --spp 1000000 --time {SECONDS} -o out/path.exr",
    "photon mapping, the scene's settings": f"render {CAUSTIC} --passes 1000000 --time {SECONDS} -o out/photons.exr",
    "photon mapping, radius 3":
        f"render {CAUSTIC} --passes 1000000 --time {SECONDS} --radius 3 --photons 2e6 -o out/photons_3.exr",
}
CROP = "--crop 328,460,48,32"


def picture(command):
    return command.rsplit(" ", 1)[1]


def difference(first, second):
    return caustica_json(f"compare {picture(first)} {picture(second)} {CROP} --json")["rel_mse"]


def steps(command):
    """Renders, and tells passes or samples as the program does."""
    return re.search(r"^\d+ (passes|samples)", finished(PROGRAM, *command.split()).stderr, re.MULTILINE)[0]


def caustic():
    """Three minutes."""
    for command in LIGHT:
        caustica(command)
    between = difference(*LIGHT)
    rows, errors = [], []
    for name, command in RIVALS.items():
        took = steps(command)
        against = [difference(command, reference) for reference in LIGHT]
        errors.append((sum(against) - between) / 2)
        rows.append([name, took, *map(digits, against), digits(errors[-1]), digits(errors[0] / errors[-1])])
    if min(errors) <= 0:
        sys.exit(f"the references' noise, {between / 2}, hides the errors of photon mapping: render them for longer")
    head = ["method", "in the time", "against the first", "against the second", "without their noise", "times nearer"]
    return paragraphs(
        table(head, rows),
        f"relMSE, {SECONDS} seconds each on {machine()}. The two references differ by {digits(between)}, so the noise of either is some "
        f"{digits(between / 2)}. Photon mapping is {span([errors[0] / error for error in errors[1:]])} times nearer than path tracing.",
        typed(*LIGHT, *RIVALS.values(), f"compare out/photons_3.exr out/light_8.exr {CROP}    # and so on"),
    )


SLOPES = re.compile(r"alpha ([\d.]+): variance falls as N\^(\S+), bias² as N\^(\S+)")


def convergence():
    """Minutes, and those of building the tests."""
    told = run("make", "convergence")
    slopes = [tuple(map(float, found)) for found in SLOPES.findall(told)]
    rows = [
        [f"{alpha:.3g}", f"{variance:.3f}", f"{-alpha:.3f}", f"{bias2:.3f}", f"{-2 * (1 - alpha):.3f}"] for alpha, variance, bias2 in slopes
    ]
    off = max(max(abs(variance + alpha), abs(bias2 + 2 * (1 - alpha))) for alpha, variance, bias2 in slopes)
    return paragraphs(
        table(["α", "variance", "in theory `-α`", "squared bias", "in theory `-2 (1 - α)`"], rows),
        f"No exponent is more than {off:.3f} off theory.",
    )


EXACT = "reference data/course_diffuse.toml --size 96x96 --spp 4096 --seed 99 -o out/diffuse_4096.exr"
PARTS = (
    "data/course_diffuse.toml --reference out/diffuse_4096.exr --reference-stderr out/diffuse_4096_stderr.exr "
    "--axes convergence --size 96x96 --budget 240"
)
RATES = {"variance": "variance", "squared bias": "bias2", "squared bias of flat pixels": "flat_bias2"}


def slope(rate):
    if rate["measured"] is None:
        return "not told apart from 0"
    width = f" ± {rate['standard_error']:.2f}" if rate["standard_error"] is not None else ""
    return f"{-rate['measured']:.2f}{width} ({-rate['of_schedule']:.2f})"


def agreement(told, name, key):
    """One sentence: by how many standard errors the slopes of a bias are off those of the radii."""
    rates = [curve["convergence"][key] for curve in told]
    known = [rate for rate in rates if rate["standard_error"]]
    if not known:
        return f"The {name} is not told apart from 0."
    off = [abs(rate["measured"] - rate["of_schedule"]) for rate in known]
    times = [distance / rate["standard_error"] for distance, rate in zip(off, known)]
    verdict = "in agreement" if max(times) <= 2 else "so **theory is not confirmed here**"
    return f"The {name} is off by {span(off, '{:.2f}'.format)}, {span(times, '{:.1f}'.format)} standard errors: {verdict}."


def parts():
    """Four minutes."""
    caustica(EXACT)
    told = [curve for curve in study(PARTS, "out/study_parts")["curves"] if curve["axis"] == "convergence"]
    rows = [[curve["name"], *(slope(curve["convergence"][key]) for key in RATES.values())] for curve in told]
    return paragraphs(
        table(["configuration", *RATES], rows),
        "Slopes over the last factor of eight of the passes, with one standard error; in brackets what the radii of these passes make of "
        f"theory. {' '.join(agreement(told, name, key) for name, key in RATES.items() if key != 'variance')}",
        typed(EXACT, f"study {PARTS} -o out/study_parts"),
    )


WATER = "data/course_water.toml --make-reference --axes alpha,radius,policy --size 96x96 --budget 240"
TARGET = 10.0
STUDY_HEAD = ["configuration", "passes", "error (%)", "exponent", "noise, bias in theory", "half costs", f"time to {TARGET:.0f} %"]


def study_row(curve):
    end = curve["points"][-1]
    error = digits(end["error_percent"]["mean"])
    return [curve["name"], end["steps"], error, exponent(curve), theory(curve), price_of_half(curve), reached(curve, TARGET)]


def winner(told, axis):
    """One sentence: who of an axis and the baseline is at the target first."""
    rivals = [curve for curve in told["curves"] if curve["axis"] in (axis, "baseline") and seconds_to(curve, TARGET)]
    if not rivals:
        return f"Along `{axis}` nobody gets to {TARGET:.0f} %."
    rivals.sort(key=lambda curve: seconds_to(curve, TARGET)[0])
    order = ", ".join(f"{curve['name']} ({reached(curve, TARGET)})" for curve in rivals)
    return f"Along `{axis}` the order of arrival at {TARGET:.0f} % is {order}."


def blurred(told):
    """One sentence: whose error falls more slowly than noise would, beyond what the repetitions leave open."""
    known = [curve for curve in told["curves"] if curve["exponent"] is not None]
    slow = [c["name"] for c in known if c["exponent"] + 2 * (c["exponent_half_width"] or 0) < c["theory"]["noise"]]
    if not slow:
        return "All errors fall as noise does: no disc is so large that its blur tells yet."
    return f"More slowly than noise fall the errors of {', '.join(slow)}: not noise alone is left there, and each further half costs more."


def water():
    """Four minutes."""
    told = study(WATER, "out/study_water")
    made = told["reference_made"]
    return paragraphs(
        table(STUDY_HEAD, map(study_row, told["curves"])),
        f"On {machine()}, {told['repetitions']} repetitions; the noise of the reference is {digits(made['error_percent'], 2)} %.",
        " ".join([*(winner(told, axis) for axis in ("alpha", "radius", "policy")), blurred(told)]),
        typed(f"study {WATER} -o out/study_water"),
    )


SPP = 2048
NEUTRAL = f"reference data/course_diffuse.toml --size 96x96 --spp {SPP} --seed 99 -o out/diffuse.exr"
DIFFUSE = "data/course_diffuse.toml --reference out/diffuse.exr --axes method --size 96x96 --repetitions 2 --budget 120"
DIFFUSE_HEAD = ["method", "passes or samples", "seconds (smallest, largest)", "error (%)", "exponent over seconds", "half costs"]


def own_errors(told):
    """(seconds, error) along the curve of each method, without the reference's noise: its variance is that of a path-traced picture,
    times the one's samples over the other's."""
    by_name = curves(told)
    traced = by_name["path tracing"]["points"][-1]
    noise = traced["rel_mse"] * traced["steps"] / (traced["steps"] + SPP)
    own = {
        name: [(p["seconds"]["median"], (p["rel_mse"] - noise) ** 0.5) for p in curve["points"] if p["rel_mse"] > noise]
        for name, curve in by_name.items()
    }
    return own, noise**0.5


def verdict(photons, rival, name):
    """One sentence: which of both has the smaller error at equal time, and when that changes."""
    crossing = overtaking(photons, rival)
    if crossing is None and is_ahead(photons, rival):
        return f"{name.capitalize()} has the smaller error wherever both are known."
    if crossing is None:
        return f"Photon mapping has a smaller error than {name} when it ends, and by the exponents that stays so."
    how = "measured" if crossing.is_measured else "an extrapolation by the exponents"
    return (
        f"{name.capitalize()} falls below photon mapping after {digits(crossing.seconds, 2)} s, at an error of "
        f"{percent(crossing.error, 1)} % ({how}): until then photon mapping wins, from then on {name} does."
    )


def diffuse():
    """Four minutes."""
    caustica(NEUTRAL)
    told = study(DIFFUSE, "out/study_diffuse")
    own, noise = own_errors(told)
    rows = []
    for name, curve in curves(told).items():
        end, fit = curve["points"][-1], fitted(own[name])
        shown, error = "photon mapping" if name == "baseline" else name, percent(own[name][-1][1])
        rows.append([shown, end["steps"], spread(end["seconds"]), error, f"{fit:.3f}", f"x {2 ** (1 / fit):.1f}"])
    photons = own.pop("baseline")
    return paragraphs(
        table(DIFFUSE_HEAD, rows),
        f"On {machine()}, {told['repetitions']} repetitions. The reference's noise, {percent(noise)} %, is taken off the errors.",
        "\n".join(verdict(photons, rival, name) for name, rival in own.items()),
        typed(NEUTRAL, f"study {DIFFUSE} -o out/study_diffuse"),
    )


FIGURES = {
    "honesty": honesty,
    "predictions": predictions,
    "estimates": estimates,
    "caustic": caustic,
    "convergence": convergence,
    "parts": parts,
    "water": water,
    "diffuse": diffuse,
}
