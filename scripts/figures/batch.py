"""Figures of docs/batch.md."""

import os
import statistics

from batch_cost import CELLS, FRAMES, JOBS, PASSES, PHOTONS, SIZE, batch_against_renders, frames, start_up
from cluster_model import HEAD, NODES, Costs, cells, prediction
from figures.shards import costs
from figures.tools import OUT, PROGRAM, commands, machine, paragraphs, span, table

REPETITIONS = 2


def cost():
    """A minute and a half."""
    folder, cores = OUT / "batch", len(os.sched_getaffinity(0))
    folder.mkdir(parents=True, exist_ok=True)
    ready, bare = map(statistics.median, start_up(PROGRAM, folder))
    shared = frames(PROGRAM, folder, cores)
    rounds = [batch_against_renders(PROGRAM, folder, JOBS, cores) for _ in range(REPETITIONS)]

    def spread(name):
        return span([numbers[name] for numbers in rounds], "{:.3f}".format)

    rows = [
        ["start-up of a job: its process; until its scene is loaded and built", f"{1e3 * bare:.1f} ms; {1e3 * ready:.1f} ms (medians)"],
        ["the batch, against the seconds that its renders took divided by cores", spread("against its renders")],
        ["the batch, against the processes one by one divided by cores", spread("against processes")],
        ["the batch, against the seconds that renders take alone divided by cores", spread("against renders")],
        ["renders side by side in the batch, against renders alone", spread("renders beside each other")],
        ["processor seconds, against the processes one by one", spread("processor seconds")],
        [f"{FRAMES} frames that share {2 * CELLS * CELLS:,} triangles", frames_cell(shared)],
    ]
    return paragraphs(
        table(["what", "measured"], rows),
        f"{JOBS} jobs of {SIZE.replace('x', ' x ')} pixels, {PASSES} passes of {PHOTONS:,} photons, one thread each; on {machine()}, "
        f"{REPETITIONS} repetitions.",
        commands("python3 scripts/batch_cost.py target/release/caustica"),
    )


def frames_cell(shared):
    whole = f"{shared['seconds']:.1f} s in {shared['processes']} processes"
    firsts = span(shared["firsts"], "{:.2f}".format)
    return f"{whole}; the first frame of each loads in {firsts} s, the others in {shared['others']:.2f} s (median)"


def cluster():
    """Those of `shards.cost`, where it was not measured in the same run, and seconds."""
    found = costs()
    rounded = {name: float(f"{found[name]:.3g}") for name in ("setup", "pass", "merge", "plain")}
    # As `cluster_model.py` takes it by default; the picture that was measured is as large.
    predictions = [prediction(nodes, Costs(rounded["setup"], rounded["pass"], rounded["merge"], rounded["plain"])) for nodes in NODES]
    worths = {row[0]: row[-1] for row in predictions}
    fastest = max(predictions, key=lambda row: row[-2])
    flags = " ".join(f"--{name} {value}" for name, value in rounded.items())
    return paragraphs(
        table(HEAD, map(cells, predictions)),
        f"A pass of a shard takes {found['pass'] / found['plain']:.2f} times as long as one of a whole render, so a single node is worth "
        f"{100 * worths[1]:.0f} % of what it is without shards. The picture is there soonest with {fastest[0]:,} nodes, "
        f"{fastest[-2]:.0f} times as fast as by a whole render on one. {half_lost(worths)}",
        commands(f"python3 scripts/cluster_model.py {flags}"),
    )


def half_lost(worths):
    """One sentence: from how many nodes on each is worth less than half of a single one."""
    poor = [nodes for nodes, worth in worths.items() if worth < worths[1] / 2]
    return f"From {min(poor):,} nodes on each is worth less than half of a single one." if poor else "No number of nodes halves what each is worth."


FIGURES = {"cost": cost, "cluster": cluster}
