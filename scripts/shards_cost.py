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


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program, *rest = sys.argv[1:]
    name = rest[0] if rest else "data/course_water.toml"
    size = rest[1] if len(rest) > 1 else "1024x1024"
    width, height = map(int, size.split("x"))
    megapixels = width * height / 1e6
    with tempfile.TemporaryDirectory() as folder:
        rounds = [
            (whole(program, (name, "--size", size), folder), *in_shards(program, (name, "--size", size), folder))
            for _ in range(ROUNDS)
        ]
    plain, setup, partial, merge, bytes_in_all = (min(column) for column in zip(*rounds))
    print(f"{name}, {size}")
    print(f"set-up of a shard      {setup:8.2f} s")
    print(f"pass of a whole render {plain:8.3f} s")
    print(f"pass of a shard        {partial:8.3f} s")
    print(f"merging                {merge / SHARDS / megapixels:8.3f} s a shard and megapixel")
    print(f"a shard on disk        {bytes_in_all / SHARDS / width / height:8.1f} bytes a pixel")


if __name__ == "__main__":
    main()
