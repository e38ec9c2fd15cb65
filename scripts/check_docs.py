#!/usr/bin/env python3
"""Checks that what the documents refer to exists: files, make targets, sub-commands.

usage: check_docs.py PROGRAM
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"\]\(([^)\s]+)\)|^\[[^\]]+\]:\s*(\S+)", re.MULTILINE)
COMMAND_START = r"(?:^|`|&&|[$]) *"
MAKE = re.compile(COMMAND_START + r"make ([a-z][\w-]*)", re.MULTILINE)
CAUSTICA = re.compile(COMMAND_START + r"(?:[\w./]*/)?caustica ([a-z][a-z-]*)", re.MULTILINE)
CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.MULTILINE | re.DOTALL)


def documents():
    names = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "CHANGELOG.md")]
    return [path for path in names if path.exists()] + sorted((ROOT / "docs").glob("*.md"))


def sub_commands(program):
    text = subprocess.run([program, "--help"], check=True, capture_output=True, text=True).stdout
    listed = re.search(r"^Commands:\n(.*?)(?:\n\n|\Z)", text, re.MULTILINE | re.DOTALL)
    return set(re.findall(r"^  ([a-z][a-z-]*)", listed[1], re.MULTILINE)) if listed else set()


def make_targets():
    return set(re.findall(r"^([A-Za-z][\w./-]*):(?!=)", (ROOT / "Makefile").read_text(), re.MULTILINE))


def faults(path, targets, commands):
    text = path.read_text()
    code = "\n".join(match[0] for match in CODE.finditer(text))
    for match in LINK.finditer(CODE.sub("", text)):
        link = (match[1] or match[2]).split("#")[0]
        if link and not re.match(r"[a-z]+:", link) and not (path.parent / link).exists():
            yield f"links to {link}, which does not exist"
    for target in sorted(set(MAKE.findall(code)) - targets):
        yield f"names `make {target}`, which is no target of the Makefile"
    for command in sorted(set(CAUSTICA.findall(code)) - commands):
        yield f"names `caustica {command}`, which is no sub-command"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    targets, commands = make_targets(), sub_commands(sys.argv[1])
    found = [f"{path.relative_to(ROOT)} {fault}" for path in documents() for fault in faults(path, targets, commands)]
    for fault in found:
        print(fault, file=sys.stderr)
    print(f"check-docs: {len(documents())} documents, {len(found)} faults")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
