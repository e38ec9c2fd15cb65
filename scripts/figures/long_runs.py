"""Figures of docs/long-runs.md."""

import statistics

from figures.tools import ROOT, caustica_lines, digits, machine, paragraphs, typed

CHECKPOINT = "out/figures_water.checkpoint"
RENDER = f"render data/course_water.toml --passes 40 --json - --checkpoint {CHECKPOINT} --checkpoint-every 0"


def written(*options):
    """Seconds that each checkpoint took, by what passes take more in all than each says of itself, and megabytes."""
    for path in (ROOT / CHECKPOINT, ROOT / f"{CHECKPOINT}.previous"):
        path.unlink(missing_ok=True)
    lines = caustica_lines(RENDER, *options)
    pairs = list(zip(lines, lines[1:]))
    seconds = [after["seconds_in_all"] - before["seconds_in_all"] - after["seconds"] for before, after in pairs]
    return seconds, (ROOT / CHECKPOINT).stat().st_size / 1e6


def checkpoint():
    """Half a minute."""
    (seconds, size), (_, with_layers) = written(), written("--layers")
    median = statistics.median(seconds)
    return paragraphs(
        f"For the water scene at 512 x 512 pixels with four samples that is {size:.0f} MB ({with_layers:.0f} MB with `--layers`), twice on "
        f"disk. On {machine()} writing it takes {digits(median, 2)} s (median of {len(seconds)}; {digits(min(seconds), 2)} at best), so one a "
        f"minute costs {digits(100 * median / 60, 2)} %: by what `seconds_in_all` of each pass grows beyond its `seconds`.",
        typed(RENDER.replace("--json -", "--json out/passes.jsonl").replace(CHECKPOINT, "out/water.checkpoint")),
    )


FIGURES = {"checkpoint": checkpoint}
