"""Figures of docs/shards.md."""

import functools

from figures.tools import PROGRAM, commands, machine, paragraphs, table
from shards_cost import ROUNDS, SCENE, SIZE, lines, measured


@functools.cache
def costs():
    """Once for all figures of a run: the model of many nodes goes by the numbers that stand here."""
    return measured(str(PROGRAM), SCENE, SIZE)


def cost():
    """A minute."""
    found = costs()
    return paragraphs(
        table(["what", "measured"], lines(found)),
        f"On {machine()}, the least of {ROUNDS} rounds. A pass of a shard takes {found['pass'] / found['plain']:.2f} times as long as one of "
        f"a whole render, and the set-up as long as {found['setup'] / found['pass']:.0f} passes.",
        commands(f"python3 scripts/shards_cost.py target/release/caustica {SCENE} {SIZE}"),
    )


FIGURES = {"cost": cost}
