#!/usr/bin/env python3
"""Tells what shards cost: the set-up of each, what they add to a pass, and merging them.

usage: shards_cost.py PROGRAM [SCENE [WxH]]

Renders eight passes as a whole by the shared schedule and in four shards, by turns, and merges the shards. Seconds are the
least of three rounds.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROUNDS, PASSES, SHARDS = 3, 8, 4
SCENE, SIZE = "data/course_water.toml", "1024x1024"


def run(*arguments):
    return subprocess.run(arguments, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout


def whole(program, scene, folder):
    """Seconds a pass of an ordinary render, which keeps no statistics of errors either."""
    flags = ("--radius-policy", "shared", "--no-error-estimates", "--passes", str(PASSES), "--json", "-")
    lines = run(program, "render", *scene, *flags, "-o", f"{folder}/whole.exr").splitlines()
    return sum(json.loads(line)["seconds"] for line in lines) / len(lines)


def in_shards(program, scene, folder):
    """Seconds of a set-up, of a pass, and of merging, and bytes of the shards."""
    each = PASSES // SHARDS
    paths = [Path(folder) / f"{k}.shard" for k in range(SHARDS)]
    for k, path in enumerate(paths):
        path.unlink(missing_ok=True)
        run(program, "render", *scene, "--partial", "--passes", f"{k * each}..{k * each + each}", "-o", str(path))
    start = time.perf_counter()
    told = json.loads(run(program, "merge", *map(str, paths), "-o", f"{folder}/merged.exr", "--json"))
    merge = time.perf_counter() - start
    size = sum(path.stat().st_size for path in paths)
    return told["setup_seconds"] / SHARDS, told["pass_seconds"] / PASSES, merge, size


def measured(program, name, size):
    """Seconds of set-up, passes (a whole render's and a shard's) and merging, and bytes a pixel of a shard."""
    width, height = map(int, size.split("x"))
    scene = (name, "--size", size)
    with tempfile.TemporaryDirectory() as folder:
        rounds = [(whole(program, scene, folder), *in_shards(program, scene, folder)) for _ in range(ROUNDS)]
    plain, setup, partial, merge, bytes_in_all = (min(column) for column in zip(*rounds))
    megapixels = width * height / 1e6
    return {
        "setup": setup,
        "plain": plain,
        "pass": partial,
        "merge": merge / SHARDS / megapixels,
        "bytes": bytes_in_all / SHARDS / width / height,
    }


# What is told of each number.
LINES = {
    "setup": ("set-up of a shard", "{:.2f} s"),
    "plain": ("pass of a whole render", "{:.3f} s"),
    "pass": ("pass of a shard", "{:.3f} s"),
    "merge": ("merging", "{:.3f} s a shard and megapixel"),
    "bytes": ("a shard on disk", "{:.1f} bytes a pixel"),
}


def lines(costs):
    """What is measured, and the number with its unit."""
    return [(words, form.format(costs[name])) for name, (words, form) in LINES.items()]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program, *rest = sys.argv[1:]
    name = rest[0] if rest else SCENE
    size = rest[1] if len(rest) > 1 else SIZE
    print(f"{name}, {size}")
    for words, number in lines(measured(program, name, size)):
        print(f"{words:22} {number}")


if __name__ == "__main__":
    main()
