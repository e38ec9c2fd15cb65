"""Figures of docs/performance.md."""

import time

import count_instructions
from figures.aim import aim, trial
from figures.gather import gather, growth, real, variants
from figures.goals import goals
from figures.passes import passes
from figures.rays import rays
from figures.tools import caustica_json, commands, paragraphs, table


def machine():
    """A second."""
    report = caustica_json("bench --pass data/cornell_b.toml --samples 1 --repetitions 1 --json -")
    its = report["machine"]
    rows = [
        ["processor", its["cpu"]],
        ["cores", its["cores"]],
        ["vector instructions", f"{' '.join(its['cpu_features'])}; the program's lanes use {its['lanes']}"],
        ["program", f"caustica {its['version']}, compiled for {' '.join(its['compiled_for'])} by {its['rustc']}"],
        ["Embree", its["embree"]],
        ["date", time.strftime("%Y-%m-%d")],
    ]
    return table(["measured on", ""], rows)


KERNELS = {
    "build": "tree over 100,000 spheres",
    "refit": "refitting it",
    "count": "counting 20,000 photons in it",
    "eye": "eye paths of the course scene, a sample a pixel",
    "photons": "tracing 20,000 photons of the course scene",
    "pass": "the whole pass of them",
    "embree": "their rays by Embree",
    "custom": "their rays by the own tree",
}


def instructions():
    """Two minutes, and the build of the benchmark before, which takes five more."""
    path = count_instructions.program()

    def row(kernel):
        count, units, unit = count_instructions.count(path, kernel)
        return [f"`{kernel}`", KERNELS[kernel], f"{count / units:,.0f} a {unit}"]

    rows = [row(kernel) for kernel in count_instructions.KERNELS]
    return paragraphs(table(["kernel", "what", "instructions"], rows), commands("make instructions"))


FIGURES = {
    "machine": machine,
    "passes": passes,
    "instructions": instructions,
    "rays": rays,
    "gather": gather,
    "growth": growth,
    "real": real,
    "variants": variants,
    "aim": aim,
    "trial": trial,
    "goals": goals,
}
