"""The photon pass: against bare tracing, on one thread and on all, with eye paths kept and traced anew."""

from statistics import median

from figures.tools import (
    caustica_json,
    commands,
    digits,
    from_to,
    keep,
    paragraphs,
    table,
    with_ends,
)

COURSE, WIDE, NARROW = "course", "wide", "narrow"
CORNELL = "data/cornell_b.toml --samples 1 --photons 100000 --radius"
SCENES = {
    COURSE: ("`course_diffuse`, radius 0.5", "data/course_diffuse.toml"),
    WIDE: ("`cornell_b`, radius 10", f"{CORNELL} 10"),
    NARROW: ("`cornell_b`, radius 2.2", f"{CORNELL} 2.2"),
}
KEPT = {key: f"bench --pass {scene}" for key, (_, scene) in SCENES.items()}
ANEW = {f"{key} anew": f"{KEPT[key]} --retrace" for key in (WIDE, NARROW)}
RUNS = KEPT | ANEW

ROUNDS = 3
REPETITIONS = 11

STATISTICS_BYTES = 40
NORMAL_BYTES = 12


def measure():
    """Reports of every run, a list for each number of threads: of `ROUNDS` rounds, in which all take turns."""
    reports = {key: {"one": [], "all": []} for key in RUNS}
    for _ in range(ROUNDS):
        for key, run in RUNS.items():
            for threads, option in (("all", ""), ("one", "--threads 1")):
                reports[key][threads].append(caustica_json(run, option, f"--repetitions {REPETITIONS} --json -"))
    return keep("performance.passes", reports)


def times(reports, phase=None):
    """Milliseconds of the pass, or of one of its phases, round by round."""
    return [1e3 * (report["phases"][phase] if phase else report["seconds_per_pass"]) for report in reports]


def values(reports, key):
    return [report[key] for report in reports]


def title(key):
    return SCENES[key.split()[0]][0]


def middle(numbers):
    return digits(median(numbers))


def phases(key, reports):
    cells = [
        title(key),
        with_ends(times(reports)),
        middle([1e3 * seconds for seconds in values(reports, "bare_trace_seconds")]),
        with_ends(values(reports, "ratio_to_bare")),
        middle(values(reports, "photons_per_second")),
    ]
    return cells + [middle(times(reports, phase)) for phase in ("trace", "gather")]


PHASES_HEAD = ["scene", "pass (ms)", "bare (ms)", "ratio", "photons/s", "trace (ms)", "gather (ms)"]


def kept_table(reports):
    counts = ("hit_points", "rays", "overlaps")
    rows = [
        phases(key, reports[key]["all"]) + [f"{reports[key]['all'][0][count]:,.0f}" for count in counts] for key in KEPT
    ]
    return table([*PHASES_HEAD, "hit points", "rays", "photons found in radii"], rows)


def anew_table(reports):
    rows = [
        phases(key, reports[key]["all"]) + [middle(times(reports[key]["all"], phase)) for phase in ("eye", "tree")]
        for key in ANEW
    ]
    return table([*PHASES_HEAD, "eye paths (ms)", "tree (ms)"], rows)


def speed_ups(reports, phase=None):
    """How many times as fast all threads are as one, round by round."""
    return [one / all_ for one, all_ in zip(times(reports["one"], phase), times(reports["all"], phase))]


def bare_speed_ups(reports):
    seconds = [values(reports[threads], "bare_trace_seconds") for threads in ("one", "all")]
    return [one / all_ for one, all_ in zip(*seconds)]


def threads_table(reports):
    def row(key):
        of_phase = [with_ends(speed_ups(reports[key], phase)) for phase in (None, "trace", "gather")]
        ratios = with_ends(values(reports[key]["one"], "ratio_to_bare"))
        return [
            title(key) + (", anew" if key in ANEW else ""),
            middle(times(reports[key]["one"])),
            ratios,
            *of_phase,
            with_ends(bare_speed_ups(reports[key])),
        ]

    head = ["scene", "pass, one thread (ms)", "ratio, one thread", "speed-up of the pass", "of trace", "of gather"]
    return table([*head, "of bare tracing"], [row(key) for key in RUNS])


def share_of_bare(reports, phase):
    """A phase as a multiple of bare tracing, of all rounds of runs with kept eye paths."""
    return [
        report["phases"][phase] / report["bare_trace_seconds"] for key in KEPT for report in reports[key]["all"]
    ]


def remarks(reports):
    """What follows from the tables."""
    size = reports[COURSE]["all"][0]["bytes_per_hit_point"]
    tree = size - STATISTICS_BYTES - NORMAL_BYTES
    ups = {phase: [up for key in KEPT for up in speed_ups(reports[key], phase)] for phase in ("trace", "gather")}
    threads = reports[COURSE]["all"][0]["threads"]
    return "\n".join(
        [
            f"- Tracing takes {from_to(share_of_bare(reports, 'trace'), 2)} times as long as bare tracing, gathering "
            f"{from_to(share_of_bare(reports, 'gather'), 2)} times.",
            f"- On {threads} threads tracing is {from_to(ups['trace'])} times as fast as on one, and gathering "
            f"{from_to(ups['gather'])} times.",
            f"- Tree, normals and statistics take {digits(size)} bytes a hit point: {STATISTICS_BYTES} for the statistics, "
            f"{NORMAL_BYTES} for the normals, {digits(tree)} for the tree.",
        ]
    )


def passes():
    """About three minutes."""
    reports = measure()
    shown = [f"caustica {run} --repetitions {REPETITIONS}" for run in RUNS.values()]
    lead = (
        f"Medians of {ROUNDS} runs of {REPETITIONS} rounds each, all runs in turn; in brackets the smallest and the largest "
        f"of these {ROUNDS}. On {reports[COURSE]['all'][0]['threads']} threads:"
    )
    return paragraphs(
        lead,
        kept_table(reports),
        "New eye paths, and a tree over them, in every pass:",
        anew_table(reports),
        "On one thread, and how many times as fast all are:",
        threads_table(reports),
        remarks(reports),
        commands(*shown, f"caustica {RUNS[COURSE]} --repetitions {REPETITIONS} --threads 1"),
    )
