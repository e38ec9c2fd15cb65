#!/usr/bin/env python3
"""Measures the figures of the documents anew and writes them into docs/:

    make docs-figures

usage: docs_figures.py [--list | --check | NAME ...]

A figure stands in a document between `<!-- figure: NAME -->` and `<!-- end of figure -->`, and is made by the function of that
name in scripts/figures/. What was measured by this build of the program is kept in out/figures/, so an interrupted run goes on
where it was; with names, these are measured again in any case. `--check` measures nothing, and fails where a document has a
figure that nobody makes, or lacks one.
"""

import importlib
import re
import sys
import time

from figures.tools import OUT, ROOT, program_hash

MODULES = (
    "performance", "accuracy", "effects", "shards", "batch", "numerics", "formats", "assignment", "long_runs",
)
FIGURE = re.compile(r"(<!-- figure: ([\w.]+) -->\n)(.*?)(<!-- end of figure -->\n)", re.DOTALL)


def makers():
    """The functions by the names of their figures."""
    return {
        f"{name}.{figure}": maker
        for name in MODULES
        for figure, maker in importlib.import_module(f"figures.{name}").FIGURES.items()
    }


def documents():
    return sorted((ROOT / "docs").glob("*.md"))


def standing():
    """Names of the figures that documents have, with their documents."""
    return {name: path for path in documents() for _, name, _, _ in FIGURE.findall(path.read_text())}


def faults(known):
    there = standing()
    nobody = [f"{there[name].name}: nobody makes the figure {name}" for name in there if name not in known]
    return nobody + [f"no document has the figure {name}" for name in known if name not in there]


def measured(name, maker, again):
    """The Markdown of a figure: as it was kept for this program, or measured now."""
    kept = OUT / f"{name}.{program_hash()}.md"
    if again or not kept.exists():
        start = time.monotonic()
        text = maker().strip() + "\n"
        kept.write_text(text)
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
    return kept.read_text()


def write(name, text):
    for path in documents():
        before = path.read_text()
        after = FIGURE.sub(lambda m: f"{m[1]}{text}{m[4]}" if m[2] == name else m[0], before)
        if after != before:
            path.write_text(after)


def main(arguments):
    known = makers()
    if arguments == ["--list"]:
        print("\n".join(known))
        return 0
    wrong = faults(known)
    if wrong or arguments == ["--check"]:
        print("\n".join(wrong), file=sys.stderr)
        return 1 if wrong else 0
    strangers = [name for name in arguments if name not in known]
    if strangers:
        sys.exit(f"no such figure: {', '.join(strangers)}; --list tells their names")
    OUT.mkdir(parents=True, exist_ok=True)
    for name in arguments or known:
        write(name, measured(name, known[name], again=name in arguments))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
