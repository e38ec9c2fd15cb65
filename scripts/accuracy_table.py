#!/usr/bin/env python3
"""Holds what renders say of their own error against references, and prints two tables of docs/accuracy.md.

usage: accuracy_table.py PROGRAM OUTPUT_FOLDER

Every reference shares the eye paths of the picture that it judges, but no photon: 40 times as many of them, in
discs of 0.6 times the radius.
"""

import json
import sys
from pathlib import Path

from figures.tools import run, table

# Scene, radius, photons a pass: those of the scene files, for a quarter of their pixels.
SCENES = [
    ("course_diffuse", 1.0, 25_000),
    ("course_balls", 1.0, 25_000),
    ("course_water", 1.0, 25_000),
    ("cornell_a", 4.0, 50_000),
    ("cornell_b", 3.0, 50_000),
]
PASSES = 32
LONG = 320
HONESTY = ["scene", "within 90 % (%)", "within 50 % (%)", "untrusted (%)", "true error (%)", "estimate (%)", "noise, bias (%)"]
PREDICTIONS = [
    "scene", "target (%)", "asked after", "passes foretold", "passes it took", "seconds foretold", "seconds it took", "exponent",
]


def render(program, scene, output, seed, radius, photons, passes, *more):
    return run(
        program, "render", f"data/{scene}.toml", "--size", "256x256", "--seed", seed, "--eye-seed", 0,
        "--radius", radius, "--photons", photons, "--passes", passes, "-o", output, *more,
    )


def looks(path):
    """What the render said of its error, look by look: the fields of the statistics."""
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    return [(line["seconds_in_all"], line["error"]) for line in lines if "error" in line]


def judge(program, folder, scene, radius, photons):
    """How often a picture's bounds hold, and its error as it is and as the render says; all of 1."""
    reference, picture = folder / f"{scene}_reference.exr", folder / f"{scene}.exr"
    render(program, scene, reference, 2, 0.6 * radius, 40 * photons, PASSES, "--no-error-estimates")
    shares, statistics = [], folder / f"{scene}.jsonl"
    for confidence in ("90%", "50%"):
        options = ["--layers", "--confidence", confidence, "--json", statistics]
        render(program, scene, picture, 1, radius, photons, PASSES, *options)
        told = json.loads(run(program, "compare", picture, reference, "--bound", f"{picture}:bound", "--json"))
        shares.append(told["coverage"])
    error = looks(statistics)[-1][1]
    return {
        "scene": scene,
        "within": [share["share"] for share in shares],
        "untrusted": shares[0]["untrusted"],
        "true": told["rel_mse"] ** 0.5,
        **{name: error[name] for name in ("error", "noise", "bias")},
    }


def honesty_row(judged):
    within = [f"{100 * share:.1f}" for share in judged["within"]]
    true, error, noise, bias = (f"{100 * judged[name]:.2f}" for name in ("true", "error", "noise", "bias"))
    return [judged["scene"], *within, f"{100 * judged['untrusted']:.1f}", true, error, f"{noise}, {bias}"]


def foretell(program, folder, scene, radius, photons):
    """A run of `LONG` passes sets the target; a second one is to foretell when it gets there."""
    statistics = folder / f"{scene}_long.jsonl"
    options = ["--json", statistics]
    render(program, scene, folder / "long.exr", 1, radius, photons, LONG, *options)
    target = looks(statistics)[-1][1]["upper"]
    render(program, scene, folder / "long.exr", 1, radius, photons, 4 * LONG, "--target-error", target, *options)
    history = looks(statistics)
    seconds, last = history[-1]
    _, early = min(history, key=lambda look: abs(look[1]["passes"] - 0.1 * last["passes"]))
    return {
        "scene": scene,
        "target": target,
        "asked": early["passes"],
        "exponent": early["exponent"],
        "passes": (early["outlook"]["passes"], last["passes"]),
        "seconds": (early["outlook"]["seconds"], seconds),
    }


def prediction_row(told):
    passes, seconds = ([f"{number:.{places}f}" for number in told[name]] for name, places in (("passes", 0), ("seconds", 1)))
    return [told["scene"], f"{100 * told['target']:.2f}", told["asked"], *passes, *seconds, f"{told['exponent']:.3f}"]


def of_all(question, program, folder):
    """`judge` or `foretell`, for all scenes."""
    folder.mkdir(parents=True, exist_ok=True)
    return [question(program, folder, *scene) for scene in SCENES]


def honesty_table(judged):
    return table(HONESTY, map(honesty_row, judged))


def predictions_table(told):
    return table(PREDICTIONS, map(prediction_row, told))


def main():
    program, folder = (Path(argument).resolve() for argument in sys.argv[1:])
    print(honesty_table(of_all(judge, program, folder)))
    print()
    print(predictions_table(of_all(foretell, program, folder)))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()
