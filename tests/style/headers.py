# SPDX-License-Identifier: BSD-3-Clause
"""Every header of src/ compiles alone and may be included twice.

    headers.py ROOT COMPILE_COMMANDS    exit code 1 and the compiler's message for each that fails

The build itself shows that a header compiles alone if a source includes it first. Only the other
headers are compiled here, without code generation.
"""

import json
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from source_tree import files

FIRST_INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def source_of(entry: dict) -> Path:
    """The source of an entry; for a group of sources the first, which is included first."""
    path = Path(entry["file"])
    if path.parent.name != "Unity" or not path.is_file():
        return path
    match = FIRST_INCLUDE.search(path.read_text(encoding="utf-8"))
    return Path(match.group(1)) if match else path


def build_flags(root: Path, commands: list[dict]) -> dict[str, tuple[list[str], str]]:
    """Folder of src/ -> compiler with flags, and its folder; tests provide header-only layers."""
    flags: dict[str, tuple[list[str], str]] = {}
    for tree in ("src", "tests"):
        for entry in commands:
            path = source_of(entry)
            if not path.is_relative_to(root / tree):
                continue
            arguments = shlex.split(entry["command"])
            layer = path.relative_to(root / tree).parts[0]
            flags.setdefault(layer, (arguments[: arguments.index("-o")], entry["directory"]))
    return flags


def proven_by_the_build(commands: list[dict]) -> set[str]:
    """Headers that are the first include of a source, as written there."""
    first = set()
    for entry in commands:
        path = source_of(entry)
        match = path.is_file() and FIRST_INCLUDE.search(path.read_text(encoding="utf-8"))
        if match:
            first.add(match.group(1))
    return first


def compile_alone(header: str, flags: tuple[list[str], str]) -> str:
    """The compiler's message for a source that contains only this header; empty if it compiles."""
    arguments, directory = flags
    source = f'#include "{header}"\n#include "{header}"\n'
    result = subprocess.run([*arguments, "-O0", "-fsyntax-only", "-x", "c++", "-"], input=source,
                            cwd=directory, capture_output=True, text=True, check=False)
    return "" if result.returncode == 0 else f"{header}:\n{result.stderr}"


def faults(root: Path, commands: list[dict]) -> list[str]:
    """The messages for all headers that the build itself does not check."""
    flags = build_flags(root, commands)
    proven = proven_by_the_build(commands)
    found, todo = [], []
    for path in files(root, ["src"], {".hpp"}):
        header = path.relative_to(root / "src")
        if header.parts[0] not in flags:
            found.append(f"{header}: no source or test of src/{header.parts[0]} is in the build")
        elif str(header) not in proven:
            todo.append((str(header), flags[header.parts[0]]))
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        found += filter(None, pool.map(lambda item: compile_alone(*item), todo))
    print(f"{len(todo)} headers compiled alone, {len(proven)} proven by the build")
    return found


if __name__ == "__main__":
    broken = faults(Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text(encoding="utf-8")))
    print("\n".join(broken) or "every header compiles alone")
    sys.exit(1 if broken else 0)
