"""Figures of docs/effects.md."""

from effects_price import ROUNDS, prices
from figures.tools import caustica_json, caustica_lines, commands, digits, machine, paragraphs, span, table, typed

SCENES = ("cornell_b", "course_water", "course_balls", "glass_bead")


def ablated(scene):
    """(seconds, relMSE) without each effect."""
    told = caustica_json(f"explain data/{scene}.toml --ablate --passes 16 --size 256x256 --json")
    return {row["without"]: (sum(row["seconds"].values()), row["rel_mse"]) for row in told["ablation"]}


def ablation_cell(row):
    seconds, error = row
    return f"{digits(seconds)} s" + (f", {digits(error, 2)}" if error else "")


def extremes(scene, rows):
    """One sentence: what is missed most, and what takes longest, told by the render without it."""
    whole = rows["nothing"][0]
    others = [name for name in rows if name != "nothing"]
    missed, dearest = max(others, key=lambda name: rows[name][1]), min(others, key=lambda name: rows[name][0])
    told = f"`{scene}` misses {missed} most"
    saved = 1 - rows[dearest][0] / whole
    return f"{told}, and saves most time, {100 * saved:.0f} %, without {dearest}." if saved > 0 else f"{told}."


def longer(found):
    """One sentence: which renders take longer with less in them."""
    slower = [
        f"{name} of `{scene}` ({row[0] / rows['nothing'][0]:.2f} times)"
        for scene, rows in found.items()
        for name, row in rows.items()
        if row[0] > 1.1 * rows["nothing"][0]
    ]
    return f"Longer than the whole take the renders without {', '.join(slower)}." if slower else "No render takes longer than the whole."


def ablation():
    """A minute."""
    found = {scene: ablated(scene) for scene in SCENES}
    names = dict.fromkeys(name for rows in found.values() for name in rows)
    rows = [[name, *(ablation_cell(found[scene][name]) if name in found[scene] else "" for scene in SCENES)] for name in names]
    return paragraphs(
        table(["without", *(f"`{scene}`" for scene in SCENES)], rows),
        f"On {machine()}.",
        "\n".join([*(extremes(scene, rows) for scene, rows in found.items()), longer(found)]),
        typed("explain data/cornell_b.toml --ablate --passes 16 --size 256x256    # and so on"),
    )


KERNEL_WORDS = {"eye": "eye pass", "photons": "tracing photons", "pass": "a whole pass"}


def unused():
    """Half a minute, and the builds of two benchmarks."""
    found = prices()
    most = [max(0.0, 100 * max(column)) for column in zip(*found.values())]
    rows = [[KERNEL_WORDS[name], *(f"{100 * more:+.2f} %" for more in both)] for name, both in found.items()]
    return paragraphs(
        table(["kernel", "instructions", "time"], rows),
        f"On {machine()}; time is the least of {ROUNDS} runs in turns. A build for such scenes alone could save at most {most[0]:.2f} % of the "
        f"instructions, and {most[1]:.2f} % of the time.",
        commands("scripts/effects_price.py"),
    )


APART = [
    ("`cornell_b`, 1 sample, radius 10", "data/cornell_b.toml --radius 10 --samples 1 --photons 100000 --repetitions 31"),
    ("`cornell_b`, 1 sample, radius 2.2", "data/cornell_b.toml --radius 2.2 --samples 1 --photons 100000 --repetitions 31"),
    ("`course_water`, 4 samples", "data/course_water.toml --repetitions 21"),
]


APART_COLUMNS = {"seconds_per_pass": 1e3, "ratio_to_bare": 1.0, "bytes_per_hit_point": 1.0}


def apart():
    """Half a minute."""
    rows, prices_apart = [], []
    for scene, arguments in APART:
        both = [caustica_json(f"bench --pass {arguments} {kind} --json -") for kind in ("", "--apart")]
        prices_apart.append(both[1]["seconds_per_pass"] / both[0]["seconds_per_pass"])
        passes, *pairs = [[digits(scale * told[name]) for told in both] for name, scale in APART_COLUMNS.items()]
        rows.append([scene, *passes, *map(", ".join, pairs)])
    head = ["scene", "together (ms a pass)", "apart (ms a pass)", "ratios to bare rays", "bytes a hit point"]
    return paragraphs(
        table(head, rows),
        f"On {machine()}, medians. Apart, a pass takes {span(prices_apart, '{:.2f}'.format)} times as long.",
        typed(*(f"bench --pass {arguments} --apart" for _, arguments in APART)),
    )


GUIDE = "bench --guide data/keyhole.toml --passes 10 --repetitions 4"


def arriving(natural, guided):
    return f"{digits(100 * natural, 2)} %, {digits(100 * guided, 2)} % if guided"


def guiding_row(row):
    error = digits(row["mean_error"], 2), span([row["photons"][end] for end in ("min", "max")], two_digits)
    seconds = map(two_digits, (row["seconds"]["median"], row["trial_seconds"]))
    found = arriving(*row["arriving"]) if row["arriving"] else ""
    return [row["guiding"], f"{row['share']:.2f}", found, "{} ({})".format(*error), *seconds, f"{row['gain']:.1f}"]


def two_digits(value):
    return digits(value, 2)


def guiding():
    """A minute and a half."""
    told = caustica_json(f"{GUIDE} --json -")
    off, auto = told["rows"][:2]
    passes = [row["seconds"]["median"] - row["trial_seconds"] for row in (off, auto)]
    less, longer_run = off["mean_error"] / auto["mean_error"], passes[0] / passes[1]
    return paragraphs(
        table(["guiding", "guided", "arrive", "error", "seconds a run", "of them trials", "gain at equal time"], map(guiding_row, (off, auto))),
        f"On {machine()}, {told['passes']} passes of {told['photons']:,} photons. The error is {digits(less, 2)} times less for as many photons. "
        f"In a render so long that trials do not count the gain would be {digits(less * longer_run, 2)}.",
        typed(GUIDE),
    )


TRIED = ("course_diffuse", "course_balls", "course_water", "glass_bead")


def trial(scene):
    """The first record and the seconds of a render of 64 passes, and its seconds of trials beyond those of one without guiding."""
    render = f"render data/{scene}.toml --passes 64 --size 256x256 --json -"
    renders = [caustica_lines(f"{render} --guiding {mode} -o out/guiding_{mode}.exr") for mode in ("auto", "off")]
    first, without = (lines[0]["setup"] for lines in renders)
    same = caustica_json("compare out/guiding_auto.exr out/guiding_off.exr --json")["mse"] == 0.0
    return first["guide"], (first["aim_seconds"] - without["aim_seconds"]) / renders[0][-1]["seconds_in_all"], same


def trials():
    """A minute."""
    rows, changed = [], []
    for scene in TRIED:
        guide, share, same = trial(scene)
        arrive = arriving(guide["arriving"], guide["guided_arriving"])
        rows.append([f"`{scene}`", arrive, guide["rounds"], f"{guide['rays']:,}", f"{guide['share']:.2f}", f"{100 * share:.1f} %"])
        changed += [] if same else [scene]
    verdict = f"Pictures differ in {', '.join(changed)}." if changed else "All pictures are those of `--guiding off`, pixel by pixel."
    return paragraphs(
        table(["scene", "arrive", "rounds", "rays", "guided", "of 64 passes"], rows),
        f"On {machine()}, 256 x 256 pixels. {verdict}",
        typed(
            "render data/course_diffuse.toml --passes 64 --size 256x256 --json -",
            "render data/course_diffuse.toml --passes 64 --size 256x256 --json - --guiding off",
        ),
    )


FIGURES = {
    "ablation": ablation,
    "unused": unused,
    "apart": apart,
    "guiding": guiding,
    "trials": trials,
}
