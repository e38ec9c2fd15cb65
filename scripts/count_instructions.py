#!/usr/bin/env python3
"""Counts the instructions of kernels by callgrind: what noise cannot blur.

usage: count_instructions.py [KERNEL ...]

Needs valgrind, which knows AVX2 but not AVX-512: kernels run as on a machine without it.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

KERNELS = ("build", "refit", "count", "eye", "photons", "pass", "embree", "custom")
BUILD = ("cargo", "bench", "--locked", "--bench", "instructions", "--no-run", "--message-format=json")


def program(*features):
    """The path of the benchmark, which is built first."""
    text = subprocess.run([*BUILD, *features], check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = (json.loads(line) for line in text.splitlines())
    paths = [m["executable"] for m in messages if m.get("target", {}).get("name") == "instructions"]
    return next(path for path in paths if path)


def count(path, kernel):
    """Instructions of one kernel, how many units it worked on, and of what."""
    with tempfile.TemporaryDirectory() as folder:
        callgrind = ["valgrind", "--tool=callgrind", "--toggle-collect=*instructions::measured*"]
        callgrind.append(f"--callgrind-out-file={folder}/callgrind.out")
        ran = subprocess.run([*callgrind, path, kernel], capture_output=True, text=True)
    collected = re.search(r"Collected : (\d+)", ran.stderr)
    if ran.returncode != 0 or not collected:
        sys.exit(f"{kernel}: valgrind failed\n{ran.stderr}")
    units, unit, _ = ran.stdout.split()
    return int(collected[1]), int(units), unit


def main():
    kernels = sys.argv[1:] or KERNELS
    path = program()
    print(f"{'kernel':10} {'instructions':>14}  {'per':8}")
    for kernel in kernels:
        instructions, units, unit = count(path, kernel)
        print(f"{kernel:10} {instructions:14,}  {instructions / units:8,.0f} a {unit}")


if __name__ == "__main__":
    try:
        main()
    except FileNotFoundError as error:
        sys.exit(f"{error.filename} is missing: install it (apt-get install valgrind)")
    except subprocess.CalledProcessError as error:
        sys.exit(f"{' '.join(error.cmd)} failed")
