#!/usr/bin/env python3
"""Simulates one picture on 1 to 10,000 nodes from what shards cost on one, and prints a table in Markdown.

usage: cluster_model.py --setup S --pass S --merge S [--plain S] [--passes N] [--megapixels M]

Take the seconds from scripts/shards_cost.py. Nodes take shards in turn until none is left. Nodes differ in speed by 5 %
(standard deviation), the scheduler takes a second to start a task, and one task in a thousand dies halfway and is given
again. For each number of nodes the passes of a shard are those among 1, 2, 5, 10 ... that end first. The merge reads shard
after shard on one node, or in two steps: a bigger shard of every group of shards on as many nodes, then one of those.
"""

import argparse
import heapq
import math
import random
from typing import NamedTuple

from figures.tools import table

NODES = [1, 10, 100, 1000, 10_000]
START_SECONDS = 1.0
SPREAD = 0.05
DEATHS = 0.001
SHARD_PASSES = [k * 10**e for e in range(6) for k in (1, 2, 5)]


class Costs(NamedTuple):
    """What shards cost on one node, in seconds: `plain` is a pass of a whole render, `merge` is of a shard and megapixel."""

    setup: float
    pass_: float
    merge: float
    plain: float
    passes: int = 100_000
    megapixels: float = 1.0


def seconds_to_shards(nodes, shards, each, costs, rng):
    """When the last shard is whole."""
    speeds = [max(0.5, rng.gauss(1.0, SPREAD)) for _ in range(nodes)]
    free = [(0.0, node) for node in range(nodes)]
    end = 0.0
    for _ in range(shards):
        now, node = heapq.heappop(free)
        work = START_SECONDS + (costs.setup + each * costs.pass_) / speeds[node]
        if rng.random() < DEATHS:
            # What it kept in the middle spares it the first half of its passes, but not the set-up.
            work += START_SECONDS + costs.setup / speeds[node]
        end = max(end, now + work)
        heapq.heappush(free, (now + work, node))
    return end


def merges(shards, nodes, costs):
    """Seconds of merging one by one, and in two steps."""
    one = costs.merge * costs.megapixels
    group = math.ceil(math.sqrt(shards))
    groups = math.ceil(shards / group)
    return shards * one, math.ceil(groups / nodes) * (START_SECONDS + group * one) + START_SECONDS + groups * one


def row(nodes, costs):
    best = None
    for each in SHARD_PASSES:
        shards = math.ceil(costs.passes / each)
        if shards > 200_000 or (best and shards < nodes / 4):
            continue
        seconds = seconds_to_shards(nodes, shards, each, costs, random.Random(nodes))
        merge = min(merges(shards, nodes, costs))
        if best is None or seconds + merge < best[0] + min(best[1]):
            best = (seconds, merges(shards, nodes, costs), each, shards)
    return best


HEAD = [
    "nodes", "passes a shard", "shards", "seconds to the last shard", "merge on one node", "merge in two steps", "against one whole render",
    "of the nodes' worth",
]


def prediction(nodes, costs):
    """A row of the table as numbers: the last two are by how many times it is faster than one node, and that over the nodes."""
    seconds, (single, steps), each, shards = row(nodes, costs)
    alone = costs.setup + costs.passes * costs.plain
    gain = alone / (seconds + min(single, steps))
    return nodes, each, shards, seconds, single, steps, gain, gain / nodes


def cells(numbers):
    nodes, each, shards, *seconds, gain, worth = numbers
    return [nodes, each, shards, *(f"{number:.0f}" for number in seconds), f"{gain:.1f} x", f"{100 * worth:.0f} %"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--setup", type=float, required=True)
    parser.add_argument("--pass", dest="pass_", type=float, required=True)
    parser.add_argument("--merge", type=float, required=True, help="seconds a shard and megapixel")
    parser.add_argument("--plain", type=float, help="seconds of a pass that is no shard's [default: as --pass]")
    parser.add_argument("--passes", type=int, default=100_000)
    parser.add_argument("--megapixels", type=float, default=1.0)
    told = parser.parse_args()
    costs = Costs(told.setup, told.pass_, told.merge, told.plain or told.pass_, told.passes, told.megapixels)
    print(table(HEAD, [cells(prediction(nodes, costs)) for nodes in NODES]))


if __name__ == "__main__":
    main()
