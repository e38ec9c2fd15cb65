#!/usr/bin/env python3
"""Tells what the ability to mirror and refract costs a scene that has no use for it.

usage: effects_price.py [ROUNDS]

Builds the kernels of `make instructions` twice, the second time with everything but Lambertian surfaces compiled out, and
runs both on the diffuse box: instructions by callgrind, and the least time of many runs taken in turns.
"""

import subprocess
import sys

from count_instructions import count, program

KERNELS = ("eye", "photons", "pass")
ROUNDS = 40
# In a folder of its own: the program itself is built as well, and must not take the place of the whole one.
WITHOUT = ("--features", "lambertian-only", "--target-dir", "target/lambertian-only")


def nanoseconds(path, kernel):
    """Of one native run."""
    return int(subprocess.run([path, kernel], check=True, stdout=subprocess.PIPE, text=True).stdout.split()[2])


def price(whole, lambertian, kernel, rounds):
    """What the whole program takes more than the other, of 1: instructions and time."""
    with_all, without = (count(path, kernel)[0] for path in (whole, lambertian))
    times = [(nanoseconds(whole, kernel), nanoseconds(lambertian, kernel)) for _ in range(rounds)]
    fastest, fastest_without = (min(column) for column in zip(*times))
    return with_all / without - 1, fastest / fastest_without - 1


def prices(rounds=ROUNDS):
    """Of all kernels, by their names."""
    whole, lambertian = program(), program(*WITHOUT)
    return {kernel: price(whole, lambertian, kernel, rounds) for kernel in KERNELS}


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    print("kernel    more instructions   more time")
    for kernel, (instructions, seconds) in prices(rounds).items():
        print(f"{kernel:8} {100 * instructions:15.2f} %   {100 * seconds:9.2f} %")


if __name__ == "__main__":
    main()
