#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs the regression cases: verdicts.py [--update] [CASE...]

A case is a folder of cases/: `commands.txt` holds commands of culm, one a line, which start in
tests/data, and `expected.txt` the verdict that all of them must give: its headline and the sizes of
the effects with two digits. A difference is printed as one; --update also writes it to expected.txt.
CULM_PROGRAM names the program.
"""
import argparse
import difflib
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

CASES = Path(__file__).resolve().parent / "cases"
DATA = CASES.parents[1] / "data"


def size_line(name: str, parameter: dict) -> str:
    low, high = parameter["interval"]
    if low <= 0.0 <= high:
        return f"{name} consistent with 0"
    return " ".join(f"{name} {float(format(parameter['value'], '.2g')):g} {parameter['unit']}".split())


def verdict_lines(command: str) -> list[str]:
    """The verdict of a command and the sizes of its effects; its messages if it has no verdict."""
    finished = subprocess.run(
        [os.environ["CULM_PROGRAM"], *shlex.split(command), "--quiet", "--json", "-"], cwd=DATA,
        text=True, capture_output=True, check=False)
    try:
        found = json.loads(finished.stdout)
    except json.JSONDecodeError:
        return [f"exit code {finished.returncode}", *finished.stderr.splitlines()]
    headline = re.sub(r" \(probability [^)]*\)", "", found["sentences"][0])
    return [headline, *(size_line(name, each) for name, each in found["parameters"].items()
                        if "." in name)]


def coloured(line: str) -> str:
    colour = {"+": 32, "-": 31}.get(line[:1])
    return f"\033[{colour}m{line}\033[0m" if colour and sys.stdout.isatty() else line


def is_as_expected(case: Path, update: bool) -> bool:
    expected_file = case / "expected.txt"
    expected = (expected_file.read_text("utf-8").splitlines() if expected_file.is_file() else [])
    good = True
    for command in (case / "commands.txt").read_text("utf-8").splitlines():
        found = verdict_lines(command)
        if found == expected:
            continue
        good = False
        print(f"{case.name}: culm {command}")
        for line in difflib.unified_diff(expected, found, "expected", "found", lineterm=""):
            print(coloured(line))
        if update:
            expected_file.write_text("\n".join(found) + "\n", "utf-8")
            expected = found
    return good


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--update", action="store_true", help="write what was found")
    parser.add_argument("cases", nargs="*", help="names of folders (default: all)")
    options = parser.parse_args()
    cases = [CASES / name for name in options.cases] or sorted(CASES.iterdir())
    if missing := [case.name for case in cases if not (case / "commands.txt").is_file()]:
        parser.error(f"no case {', '.join(missing)}; there are "
                     f"{', '.join(sorted(each.name for each in CASES.iterdir()))}")
    results = [is_as_expected(case, options.update) for case in cases]
    return 0 if all(results) or options.update else 1


if __name__ == "__main__":
    sys.exit(main())
