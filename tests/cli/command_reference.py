#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints the reference of all commands as Markdown, from --help: command_reference.py CULM.

docs/cli.md contains what it prints; `cli.help` among the tests compares.
"""

import re
import subprocess
import sys

HEADS = ("Positionals", "Options", "Subcommands")


def help_of(program: str, path: list[str]) -> str:
    return subprocess.run([program, *path, "--help"], text=True, capture_output=True,
                          check=True).stdout


def entries(text: str, head: str) -> list[tuple[str, str]]:
    """Names and descriptions below one of HEADS."""
    part = re.search(rf"(?m)^{head}:\n((?:  .*\n)+)", text)
    # A name that is too long for its column is followed by its description in the next line.
    lines = re.findall(r"(?m)^  (\S.*?)(?: {2,}|\n {10,}| (?=[A-Z][a-z]+ \S))(\S.*)$",
                       part[1] if part else "")
    return [(" ".join(name.split()), description) for name, description in lines]


def named(name: str) -> str:
    """`-o,--output DIR REQUIRED` as `-o, --output DIR`, required."""
    words = name.replace(" REQUIRED", "").replace("... ...", "...").replace(" ...", " …")
    needs = re.search(r" (Needs|Excludes): .*$", words)
    words = words[:needs.start()] if needs else words
    # The allowed range is in the description, if it is not obvious.
    words = re.sub(r":(?:INT |FLOAT |UINT )?in [\[(][^\])]*[\])]|:(?:INT|UINT|FLOAT)\b", "", words)
    words = re.sub(r"[A-Z]+:\{([^}]*)\}", lambda choices: choices[1].replace(",", "|"), words)
    words = re.sub(r"^[a-z_]+ (?=[A-Z])", "", words)  # a positional: its value says more
    text = "`" + words.replace(",-", ", -").replace("|", "\\|") + "`"
    return text + (", required" if "REQUIRED" in name else "") + (
        f" ({needs[0].strip()})" if needs else "")


def escaped(description: str) -> str:
    return description.replace("|", "\\|").replace("<", "&lt;")


def section(program: str, path: list[str]) -> str:
    """The section of a command, followed by those of its subcommands."""
    text = help_of(program, path)
    out = f"### `culm {' '.join(path)}`\n{text.splitlines()[0]}.\n\n"
    rows = [(named(name), description) for head in HEADS[:2]
            for name, description in entries(text, head) if not name.startswith("-h,")]
    if rows:
        out += "| | |\n|---|---|\n"
        out += "".join(f"| {name} | {escaped(description)} |\n"
                       for name, description in rows) + "\n"
    return out + "".join(section(program, [*path, name])
                         for name, _ in entries(text, "Subcommands"))


def reference(program: str) -> str:
    commands = entries(help_of(program, []), "Subcommands")
    return "".join(section(program, [name]) for name, _ in commands)


if __name__ == "__main__":
    print(reference(sys.argv[1]), end="")
