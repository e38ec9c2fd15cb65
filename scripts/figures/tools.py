"""What figures are made with: running the program, tables, numbers as people read them."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target" / "release" / "caustica"
OUT = ROOT / "out" / "figures"


def run(*command):
    """Standard output of `command`; ends the program, with what it said, where it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)} failed:\n{done.stderr}")
    return done.stdout


def caustica(*arguments):
    """Standard output of a command of the program; `caustica("render data/pool.toml", "--seed", 1)`."""
    return run(PROGRAM, *(word for argument in arguments for word in str(argument).split()))


def caustica_json(*arguments):
    """The one JSON value that a command prints."""
    return json.loads(caustica(*arguments))


def caustica_lines(*arguments):
    """The JSON values that a command prints, a line each."""
    return [json.loads(line) for line in caustica(*arguments).splitlines()]


def table(head, rows):
    """Markdown of a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, cells)) + " |" for cells in lines)


def commands(*lines):
    """Markdown of the commands behind a figure."""
    return "\n".join(["```sh", *lines, "```"])


def paragraphs(*parts):
    """Parts of a figure, with an empty line between them."""
    return "\n\n".join(parts)


def digits(value, significant=3):
    """A number with so many significant digits, thousands parted, no exponent: 1234567 is 1,230,000."""
    if value == 0:
        return "0"
    rounded = float(f"{value:.{significant - 1}e}")
    decimals = max(0, significant - 1 - int(f"{rounded:e}".split("e")[1]))
    return f"{rounded:,.{decimals}f}"
