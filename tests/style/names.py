# SPDX-License-Identifier: BSD-3-Clause
"""Checks names, first lines, sizes, leftovers and machine paths of the source files.

    names.py ROOT       exit code 1 and one line per fault; long files are only listed
"""

import re
import sys
from collections import Counter
from pathlib import Path

from source_tree import files

CODE_FOLDERS = ["src", "tests", "bench", "postprocess", "jobs", "cmake"]
CODE = {".hpp", ".cpp", ".py", ".sh", ".cmake"}
DOCUMENTS = {".md", ".toml", ".txt", ".json"}
# Folders that may not exist on another machine; only the tests may name them.
MACHINE_PATH = re.compile(r"(?<![\w.~})/-])/(?:work|tmp|root|home)(?![\w-])")
MACHINE_PATH_FOLDERS = ["src", "postprocess", "docs", "config", "jobs", "bench", "cmake"]
# The words are split so that the check does not find them in this file.
LEFTOVER = re.compile(r"\b(?:TO" "DO|FIX" r"ME|X" r"XX)\b")
VAGUE = re.compile(r"(?:^|_)(?:utils?|utilit(?:y|ies)|helpers?|common|misc|stuff)(?:_|$)")
LICENCE = "SPDX-License-Identifier: BSD-3-Clause"
# A file contains one idea.
LONG, TOO_LONG = 400, 500
# Files directly in a folder of src/.
MOST_IN_FOLDER = 25
# Files and lines of src/: the aim, and the present limit. When src/ becomes smaller, lower the
# limit, until it equals the aim.
AIM_FILES, AIM_LINES = 450, 50_000
MOST_FILES, MOST_LINES = 398, 58_939


def name_faults(place: Path) -> list[str]:
    """A vague word in a file's or folder's name."""
    parts = [*place.parts[:-1], place.stem]
    return [f"{place}: '{part}' names no idea" for part in parts if VAGUE.search(part.lower())]


def first_line_faults(place: Path, lines: list[str]) -> list[str]:
    """Checks the licence line of a source, and for a header also its purpose and its guard."""
    mark = "//" if place.suffix in (".hpp", ".cpp") else "#"
    head = lines[1:] if lines and lines[0].startswith("#!") else lines
    if place.suffix == ".cmake":
        return []
    if not head or head[0] != f"{mark} {LICENCE}":
        return [f"{place}:1: must be '{mark} {LICENCE}'"]
    if place.suffix != ".hpp":
        return []
    faults = []
    purpose = []
    for line in head[1:]:
        if not line.startswith("// "):
            break
        purpose.append(line[3:])
    if not re.search(r"\w.*\.(?:\s|$)", " ".join(purpose)):
        faults.append(f"{place}:2: a sentence must say what the header is for")
    if "#pragma once" not in lines:
        faults.append(f"{place}: #pragma once is missing")
    return faults


def leftover_faults(place: Path, lines: list[str]) -> list[str]:
    return [f"{place}:{number}: unfinished work belongs in an issue: {line.strip()}"
            for number, line in enumerate(lines, 1) if LEFTOVER.search(line)]


def machine_path_faults(place: Path, lines: list[str]) -> list[str]:
    if len(place.parts) > 1 and place.parts[0] not in MACHINE_PATH_FOLDERS:
        return []
    return [f"{place}:{number}: a path of one machine: {line.strip()}"
            for number, line in enumerate(lines, 1) if MACHINE_PATH.search(line)]


def sources(root: Path) -> list[Path]:
    return files(root, ["src"], {".hpp", ".cpp"})


def crowd_faults(root: Path) -> list[str]:
    """Folders of src/ with more than MOST_IN_FOLDER files, and the size of src/."""
    found = []
    all_sources = sources(root)
    folders = Counter(path.parent.relative_to(root).as_posix() for path in all_sources)
    for folder, number in sorted(folders.items()):
        if number > MOST_IN_FOLDER:
            found.append(f"{folder}: {number} files, at most {MOST_IN_FOLDER}")
    lines = sum(path.read_text(encoding="utf-8").count("\n") for path in all_sources)
    for number, most, what in ((len(all_sources), max(AIM_FILES, MOST_FILES), "files"),
                               (lines, max(AIM_LINES, MOST_LINES), "lines")):
        if number > most:
            found.append(f"src: {number} {what}, at most {most}")
    return found


def faults(root: Path) -> list[str]:
    """All faults of names, first lines, leftovers, paths and size."""
    found = crowd_faults(root)
    code = files(root, CODE_FOLDERS, CODE)
    documents = files(root, [*CODE_FOLDERS, "docs", "config"], DOCUMENTS)
    documents += sorted(path for path in root.glob("*") if path.suffix in DOCUMENTS)
    for path in [*code, *documents]:
        place = path.relative_to(root)
        lines = path.read_text(encoding="utf-8").splitlines()
        found += name_faults(place)
        found += leftover_faults(place, lines)
        found += machine_path_faults(place, lines)
        if path in code:
            found += first_line_faults(place, lines)
            if len(lines) > TOO_LONG:
                found.append(f"{place}: {len(lines)} lines, at most {TOO_LONG}")
    return found


def long_files(root: Path) -> list[str]:
    """Files that are allowed but longer than LONG lines."""
    sizes = [(len(path.read_text(encoding="utf-8").splitlines()), path)
             for path in files(root, CODE_FOLDERS, CODE)]
    return [f"{path.relative_to(root)}: {size} lines, aim at {LONG}"
            for size, path in sizes if LONG < size <= TOO_LONG]


if __name__ == "__main__":
    tree = Path(sys.argv[1])
    broken = faults(tree)
    for note in long_files(tree):
        print("warning:", note)
    print("\n".join(broken) or "names, first lines, sizes and paths are in order")
    sys.exit(1 if broken else 0)
