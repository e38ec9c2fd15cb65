"""What figures are made with: running the program, tables, numbers as people read them."""

import functools
import hashlib
import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target" / "release" / "caustica"
OUT = ROOT / "out" / "figures"


def finished(*command):
    """`command` when it is done, with all that it said; ends the program, with that, where it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)} failed:\n{done.stderr}")
    return done


def run(*command):
    """Standard output of `command`; ends the program, with what it said, where it fails."""
    return finished(*command).stdout


def caustica(*arguments):
    """Standard output of a command of the program; `caustica("render data/pool.toml", "--seed", 1)`. Paths are words, whatever is in them."""
    words = ([argument] if isinstance(argument, Path) else str(argument).split() for argument in arguments)
    return run(PROGRAM, *(word for several in words for word in several))


def caustica_json(*arguments):
    """The one JSON value that a command prints."""
    return json.loads(caustica(*arguments))


def caustica_lines(*arguments):
    """The JSON values that a command prints, a line each."""
    return [json.loads(line) for line in caustica(*arguments).splitlines()]


def merged(*lines):
    """The first report of several commands that print one, with the rows of all."""
    reports = [caustica_json(line, "--json -") for line in lines]
    return reports[0] | {"rows": [row for report in reports for row in report["rows"]]}


@functools.cache
def program_hash():
    """What tells one build of the program from another."""
    return hashlib.sha256(PROGRAM.read_bytes()).hexdigest()[:16]


def keep(name, value):
    """`value`, which is written where figures that rest on it find it."""
    (OUT / f"{name}.{program_hash()}.json").write_text(json.dumps(value))
    return value


def kept(name, measure):
    """What this build of the program measured under that name; it is measured where nothing is kept."""
    path = OUT / f"{name}.{program_hash()}.json"
    return json.loads(path.read_text()) if path.exists() else keep(name, measure())


def table(head, rows):
    """Markdown of a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, cells)) + " |" for cells in lines)


def commands(*lines):
    """Markdown of the commands behind a figure."""
    return "\n".join(["```sh", *lines, "```"])


def typed(*lines):
    """Markdown of commands of the program, as people type them."""
    return commands(*(f"caustica {line}" for line in lines))


def paragraphs(*parts):
    """Parts of a figure, with an empty line between them."""
    return "\n\n".join(parts)


def machine():
    """What measures: "2 cores of AMD EPYC"."""
    names = re.findall(r"^model name\s*: (.*\S)", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return f"{len(os.sched_getaffinity(0))} cores of {names[0] if names else platform.machine()}"


def digits(value, significant=3):
    """A number with so many significant digits, thousands parted, no exponent: 1234567 is 1,230,000."""
    if value == 0:
        return "0"
    rounded = float(f"{value:.{significant - 1}e}")
    decimals = max(0, significant - 1 - int(f"{rounded:e}".split("e")[1]))
    return f"{rounded:,.{decimals}f}"


def span(values, form=digits):
    """The smallest and the largest: `3.1 to 4.5`; one number where they look alike."""
    return " to ".join(dict.fromkeys((form(min(values)), form(max(values)))))


def from_to(values, significant=3):
    """`span` with so many significant digits."""
    return span(values, lambda value: digits(value, significant))


def with_ends(values, significant=3):
    """The median, with the smallest and the largest in brackets where they differ."""
    middle, ends = digits(median(values), significant), from_to(values, significant)
    return middle if middle == ends else f"{middle} ({ends})"
