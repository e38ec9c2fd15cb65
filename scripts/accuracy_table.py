#!/usr/bin/env python3
"""Holds what renders say of their own error against references, and prints the tables of docs/accuracy.md.

usage: accuracy_table.py PROGRAM OUTPUT_FOLDER

Every reference shares the eye paths of the picture that it judges, but no photon: 40 times as many of them, in
discs of 0.6 times the radius.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
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


def run(program, *arguments):
    command = [str(program), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


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
    reference, picture = folder / f"{scene}_reference.exr", folder / f"{scene}.exr"
    render(program, scene, reference, 2, 0.6 * radius, 40 * photons, PASSES, "--no-error-estimates")
    shares, statistics = [], folder / f"{scene}.jsonl"
    for confidence in ("90%", "50%"):
        options = ["--layers", "--confidence", confidence, "--json", statistics]
        render(program, scene, picture, 1, radius, photons, PASSES, *options)
        told = json.loads(run(program, "compare", picture, reference, "--bound", f"{picture}:bound", "--json"))
        shares.append(told["coverage"])
    error = looks(statistics)[-1][1]
    untrusted = 100 * shares[0]["untrusted"]
    within = " | ".join(f"{100 * share['share']:.1f}" for share in shares)
    true = 100 * told["rel_mse"] ** 0.5
    noise, bias = 100 * error["noise"], 100 * error["bias"]
    print(f"| {scene} | {within} | {untrusted:.1f} | {true:.2f} | {100 * error['error']:.2f} | {noise:.2f}, {bias:.2f} |")


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
    outlook = early["outlook"]
    print(
        f"| {scene} | {100 * target:.2f} | {early['passes']} | {outlook['passes']:.0f} | {last['passes']} "
        f"| {outlook['seconds']:.1f} | {seconds:.1f} | {early['exponent']:.3f} |"
    )


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    print("| scene | within 90 % (%) | within 50 % (%) | untrusted (%) | true error (%) | estimate (%) | noise, bias (%) |")
    print("|---|---|---|---|---|---|---|")
    for scene in SCENES:
        judge(program, folder, *scene)
    print()
    print("| scene | target (%) | asked after | passes foretold | passes it took | seconds foretold | seconds it took | exponent |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in SCENES:
        foretell(program, folder, *scene)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()
