#!/usr/bin/env python3
"""Runs the hard cases and prints their table, or checks that docs/hard-cases.md has it.

usage: hard_cases.py            run the cases, print the table, exit with the tests' code
       hard_cases.py --update   run the cases, write the table into docs/hard-cases.md
       hard_cases.py --check    run nothing; fail if the document's table is not that of the tests' comments
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOCUMENT = ROOT / "docs" / "hard-cases.md"
CASES = ROOT / "tests" / "hard_cases"
BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"
TEST = re.compile(r"((?:^/// ?.*\n)+)(?:#\[[^\n]*\n)*?#\[test\]\n(?:#\[[^\n]*\n)*fn (\w+)", re.MULTILINE)
ANY_TEST = re.compile(r"^#\[test\]\n(?:#\[[^\n]*\n)*fn (\w+)", re.MULTILINE)
RESULT = re.compile(r"^test (\S+) \.\.\. (ok|FAILED|ignored)", re.MULTILINE)


def paragraphs(comment):
    text = re.sub(r"^/// ?", "", comment, flags=re.MULTILINE)
    return [" ".join(part.split()) for part in re.split(r"\n\s*\n|\n(?=Breaks:|Mutation:)", text) if part.strip()]


def cases():
    """(file, test, what must hold, what breaks, the mutation) of every test, and what is wrong with the comments."""
    found, faults = [], []
    for path in sorted(CASES.rglob("*.rs")):
        text, module = path.read_text(), path.relative_to(CASES).with_suffix("").as_posix().replace("/", "::")
        told = {name: paragraphs(comment) for comment, name in TEST.findall(text)}
        for name in ANY_TEST.findall(text):
            parts = told.get(name, [])
            value = {key: next((p[len(key) + 2 :] for p in parts if p.startswith(f"{key}: ")), None)
                     for key in ("Breaks", "Mutation")}
            if None in value.values():
                faults.append(f"{path.relative_to(ROOT)}: {name} does not tell what breaks, and which mutation it catches")
                continue
            found.append((module, name, parts[0], value["Breaks"], value["Mutation"]))
    return found, faults


def table(found):
    head = ["| case | what must hold | what goes wrong otherwise | seen to fail with |", "|---|---|---|---|"]
    rows = [f"| `{module}::{name}` | {holds} | {breaks} | {mutation} |" for module, name, holds, breaks, mutation in found]
    return "\n".join(head + [row.replace("\n", " ") for row in rows]) + "\n"


def split_document():
    text = DOCUMENT.read_text()
    before, rest = text.split(BEGIN, 1)
    now, after = rest.split(END, 1)
    return before, now, after


def run():
    command = ["cargo", "test", "--locked", "--test", "hard_cases"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    return done.returncode, dict(RESULT.findall(done.stdout)), done.stdout


def print_results(found, results):
    width = max((len(f"{module}::{name}") for module, name, *_ in found), default=0)
    for module, name, holds, *_ in found:
        print(f"{results.get(f'{module}::{name}', 'not run'):7} {f'{module}::{name}':{width}}  {holds}")


def main():
    found, faults = cases()
    mode = sys.argv[1] if len(sys.argv) == 2 else None
    if len(sys.argv) > 2 or mode not in (None, "--update", "--check"):
        sys.exit(__doc__)
    for fault in faults:
        print(fault, file=sys.stderr)
    if mode == "--check":
        if split_document()[1] != table(found):
            faults.append("")
            print("docs/hard-cases.md is not up to date: make hard-cases writes its table", file=sys.stderr)
        sys.exit(1 if faults else 0)
    code, results, log = run()
    print_results(found, results)
    if code:
        print(log, file=sys.stderr)
    elif mode == "--update":
        before, _, after = split_document()
        DOCUMENT.write_text(before + BEGIN + table(found) + END + after)
    passed = sum(result == "ok" for result in results.values())
    left_out = sum(result == "ignored" for result in results.values())
    print(f"{passed} of {len(found)} hard cases hold, {left_out} take long and were left out")
    sys.exit(code or (1 if faults or passed + left_out < len(found) else 0))


if __name__ == "__main__":
    main()
