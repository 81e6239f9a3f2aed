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

from measure import RESULTS, ROOT, changed_since, git, read_result
from measurements import MEASUREMENTS
from published_blocks import BLOCKS

BLOCK = re.compile(r"^<!-- published: ([\w-]+) -->\n(.*?)^<!-- end -->$", re.M | re.S)
# A commit: seven to forty hexadecimal digits with a letter and a digit among them.
COMMIT = re.compile(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*[0-9])[0-9a-f]{7,40}\b")
# Commits of other projects, by which pages name their sources.
OTHERS_COMMITS = {"0fc7c5b": "the authors' code", "14e12b7c": "the strip", "825e7b7c": "the beam"}
MOST_LINES = {"performance.md": 200}
# Pages whose numbers are still typed by hand, with the commits that they are of.
BY_HAND = {"README.md", "archive-format.md", "diagnosis-rates.md", "effects.md", "install.md",
           "real-data.md", "reliability.md", "timestep.md", "uncertainty.md"}
MOST_RESULT_LINES = 6000
# Cases of earlier versions, from before bench/publish.sh.
HISTORY = {"coverage.json", "decision-judging.json", "decision-library-laws.json",
           "decision-second-mode.json", "decision.json", "laboratories.json",
           "moving-recordings.json", "noise-rules.json", "tracked-videos.json"}


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
    faults, used = [], set()
    for page in pages():
        text = page.read_text("utf-8")
        used |= {name for name, _ in BLOCK.findall(text)}
        try:
            if with_numbers(text, page) != text:
                faults.append(f"{page.name} differs from bench/results: run bench/publish.py")
        except KeyError as fault:
            faults.append(str(fault.args[0]))
        for number, line in enumerate(BLOCK.sub(lambda block: "\n" * block[0].count("\n"),
                                                text).splitlines(), 1):
            faults += [f"{page.name}:{number}: the commit {found} outside of a block"
                       for found in COMMIT.findall(line)
                       if found not in OTHERS_COMMITS and page.name not in BY_HAND]
        lines = text.count("\n")
        if lines > MOST_LINES.get(page.name, lines):
            faults.append(f"{page.name} has {lines} lines, {MOST_LINES[page.name]} are allowed")
    faults += [f"no page contains the block {name}" for name in sorted(set(BLOCKS) - used)]
    return faults


def quoted_files() -> set[str]:
    """The files that the blocks read."""
    names: set[str] = set()

    def read(name: str) -> dict | None:
        names.add(name)
        return read_result(name)
    for made in BLOCKS.values():
        made(read)
    return names


def faults_of_files() -> list[str]:
    faults = []
    quoted = quoted_files()
    files = sorted(RESULTS.glob("*"))
    faults += [f"{file.name}: no page quotes it" for file in files
               if file.stem not in quoted and file.name not in HISTORY]
    lines = sum(file.read_text("utf-8").count("\n") for file in files
                if file.name not in HISTORY)
    if lines > MOST_RESULT_LINES:
        faults.append(f"bench/results has {lines} lines, {MOST_RESULT_LINES} are allowed")
    faults += [f"{name}.json is missing: run bench/publish.sh BUILD" for name in sorted(quoted)
               if read_result(name) is None]
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
