"""Aimed photons: what they gain where they are needed, and what the trial costs where they are not."""

from statistics import median

from figures.tools import (
    OUT,
    caustica_json,
    caustica_lines,
    commands,
    digits,
    from_to,
    paragraphs,
    table,
    with_ends,
)

AIM = "bench --aim data/glass_bead.toml --passes 10 --repetitions 5"
SCENES = ("course_balls", "course_water")
PASSES = 64
ROUNDS = 3


def ends(spread, significant=2):
    values = [spread[key] for key in ("min", "median", "max")]
    return with_ends(values, significant)


def aim():
    """Two to three minutes, most of them for the reference."""
    report = caustica_json(AIM, "--json -")
    rows = [
        [
            f"`{row['aiming']}`",
            f"{row['aimed']:,}",
            *(ends(row[key]) for key in ("caustic", "picture")),
            ends(row["seconds"], 3),
            *(digits(row[key], 2) for key in ("caustic_gain", "picture_gain")),
        ]
        for row in report["rows"]
    ]
    head = ["`--caustic-photons`", "aimed", "error of caustic light", "error of all light", "seconds a run"]
    trial_seconds = report["rows"][1]["trial_seconds"]
    return paragraphs(
        table([*head, "gain at equal time, caustic light", "all light"], rows),
        f"Runs of {report['passes']} passes of {report['photons']:,} photons, {report['pixels']} pixels in the caustic; medians, and in "
        f"brackets the smallest and the largest. The trial takes {digits(trial_seconds, 2)} s before the first pass.",
        commands(f"caustica {AIM}"),
    )


def seconds_of_renders(scene):
    """Seconds of whole renders and of their trials, of `ROUNDS` rounds: with the trial, and without it."""
    options = {"with": "", "without": "--caustic-photons 0"}
    taken = {key: [] for key in options}
    for _ in range(ROUNDS):
        for key, option in options.items():
            passes = caustica_lines(
                f"render data/{scene}.toml --passes {PASSES} --json -", option, "-o", OUT / "trial.exr"
            )
            setup = passes[0]["setup"]
            taken[key].append((passes[-1]["seconds_in_all"], setup["aim_seconds"], setup["aim"]))
    return taken


def trial_row(scene):
    taken = seconds_of_renders(scene)
    ratios = [long[0] / short[0] for long, short in zip(taken["with"], taken["without"])]
    alone = caustica_lines(
        f"render data/{scene}.toml --transport direct,caustic --passes 1 --json -", "-o", OUT / "trial.exr"
    )
    aim_alone = alone[0]["setup"]["aim"]
    return [
        f"`{scene}`",
        f"{taken['with'][0][2]['budget']['aimed']:,}",
        digits(median(seconds for _, seconds, _ in taken["with"]), 2),
        digits(median(seconds for _, seconds, _ in taken["without"]), 2),
        with_ends([seconds for seconds, _, _ in taken["with"]]),
        with_ends(ratios),
        f"{aim_alone['budget']['aimed']:,}",
        digits(aim_alone["gain"], 2),
    ]


def trial():
    """Two minutes."""
    head = ["scene", "aimed", "trials (s)", "without that of aiming (s)", "render (s)", "as a multiple of one without"]
    rows = [trial_row(scene) for scene in SCENES]
    shown = [f"caustica render data/{scene}.toml --passes {PASSES} --json -" for scene in SCENES]
    return paragraphs(
        table([*head, "aimed for caustics alone", "foretold gain"], rows),
        f"Renders of {PASSES} passes, with the trial and with `--caustic-photons 0` in turn: medians of {ROUNDS}. The foretold gain is "
        "that in variance at equal rays where caustics alone are asked for.",
        commands(
            *(line for scene in shown for line in (scene, f"{scene} --caustic-photons 0")),
            *(f"caustica render data/{scene}.toml --transport direct,caustic --passes 1 --json -" for scene in SCENES),
        ),
    )
