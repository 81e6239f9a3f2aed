#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the numbers of bench/results into README.md and docs, between the lines
<!-- published: BLOCK --> and <!-- end -->. publish.py [--check]

With --check nothing is written. The exit code is 1 if a page differs from its numbers, if a file of
numbers is older than the sources that it measures, if a page outside of the blocks contains a
commit, or if pages or files are longer than agreed.
"""
from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

import published_blocks  # noqa: F401, registers its blocks
import rate_blocks  # noqa: F401
import recording_blocks  # noqa: F401
from block import BLOCKS, NOT_MEASURED
from measure import RESULTS, ROOT, changed_since, git, read_result
from measurements import MEASUREMENTS

BLOCK = re.compile(r"^<!-- published: ([\w-]+) -->\n(.*?)^<!-- end -->$", re.M | re.S)
# A commit: seven to forty hexadecimal digits with a letter and a digit among them.
COMMIT = re.compile(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*[0-9])[0-9a-f]{7,40}\b")
# Commits of other projects, by which pages name their sources.
OTHERS_COMMITS = {"0fc7c5b": "the authors' code", "14e12b7c": "the strip", "825e7b7c": "the beam"}
MOST_LINES = {"README.md": 120, "diagnosis.md": 110, "laboratory.md": 120, "other-tools.md": 60,
              "performance.md": 200, "real-data.md": 110, "reliability.md": 80, "uncertainty.md": 110}
MOST_RESULT_LINES = 6000


def pages() -> list[Path]:
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def with_numbers(text: str, page: Path) -> str:
    """The page with the blocks that bench/results give. Raises KeyError for an unknown block."""
    def block(match: re.Match) -> str:
        name = match[1]
        if name not in BLOCKS:
            raise KeyError(f"{page.name}: no block {name}; known are {', '.join(sorted(BLOCKS))}")
        made = BLOCKS[name](read_result)
        return f"<!-- published: {name} -->\n{made.rstrip()}\n<!-- end -->"
    return BLOCK.sub(block, text)


def faults_of_pages() -> list[str]:
    faults = []
    for page in pages():
        text = page.read_text("utf-8")
        try:
            if with_numbers(text, page) != text:
                faults.append(f"{page.name} differs from bench/results: run bench/publish.py")
        except KeyError as fault:
            faults.append(str(fault.args[0]))
        for number, line in enumerate(BLOCK.sub(lambda block: "\n" * block[0].count("\n"),
                                                text).splitlines(), 1):
            faults += [f"{page.name}:{number}: the commit {found} outside of a block"
                       for found in COMMIT.findall(line)
                       if found not in OTHERS_COMMITS]
        lines = text.count("\n")
        if lines > MOST_LINES.get(page.name, lines):
            faults.append(f"{page.name} has {lines} lines, {MOST_LINES[page.name]} are allowed")
    return faults


def quoted_files() -> set[str]:
    """The files that the blocks of the pages read."""
    names: set[str] = set()

    def read(name: str) -> dict | None:
        found = read_result(name)
        if found is not None:
            names.add(name)
        return found
    for page in pages():
        for name, _ in BLOCK.findall(page.read_text("utf-8")):
            if name in BLOCKS:
                BLOCKS[name](read)
    return names


def faults_of_files() -> list[str]:
    faults = []
    quoted = quoted_files()
    files = sorted(RESULTS.rglob("*.json"))
    faults += [f"{file.name}: no page quotes it" for file in files
               if str(file.relative_to(RESULTS).with_suffix("")) not in quoted
               and file.parent == RESULTS]
    lines = sum(file.read_text("utf-8").count("\n") for file in files)
    if lines > MOST_RESULT_LINES:
        faults.append(f"bench/results has {lines} lines, {MOST_RESULT_LINES} are allowed")
    faults += [f"{page.name}: {name} is not measured: run bench/publish.sh BUILD"
               for page in pages() for name, made in BLOCK.findall(page.read_text("utf-8"))
               if NOT_MEASURED in made]
    return faults


def faults_of_age() -> list[str]:
    if not (ROOT / ".git").exists():
        print("no repository: the age of the numbers cannot be checked")
        return []
    if git("rev-parse", "--is-shallow-repository") == "true":
        print("a shallow clone: the age of the numbers cannot be checked")
        return []
    faults = []
    for each in MEASUREMENTS:
        found = read_result(each.name)
        if found is not None and changed_since(found["commit"], each.sources):
            last = git("log", "-1", "--format=%h %s", "--", *each.sources)
            faults.append(f"{each.name}.json is of {found['commit']}, and {last} changed what it "
                          "measures: run bench/publish.sh BUILD")
    return faults


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing")
    if not parser.parse_args().check:
        for page in pages():
            text = page.read_text("utf-8")
            if (made := with_numbers(text, page)) != text:
                page.write_text(made, "utf-8")
                print(f"wrote {page.relative_to(ROOT)}")
    faults = faults_of_pages() + faults_of_files() + faults_of_age()
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except subprocess.CalledProcessError as failed:
        sys.exit(f"{' '.join(map(str, failed.cmd))}: {failed.stderr}")
