# SPDX-License-Identifier: BSD-3-Clause
"""Finds headers of src/ that include each other in a circle, and headers that no file includes.

    includes.py ROOT            exit code 1 and one line per fault
    includes.py ROOT --shrink   removes the mended faults from accepted_includes.txt

A header and the source of the same name are one unit. Units that include each other in a circle can
only be understood together: merge them, or divide them by idea. A header that no file in src/ needs
is dead or serves tests only. Clients are files of src/ other than the header's own source.

accepted_includes.txt lists the faults that existed when the check was added. It may only shrink.
"""

import re
import sys
from collections import defaultdict
from pathlib import Path

from source_tree import files

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
ACCEPTED = Path(__file__).with_name("accepted_includes.txt")
MOST_ACCEPTED = 0


def includes(root: Path) -> dict[str, set[str]]:
    """File of src/ -> the files of src/ that it includes, both as paths below src/."""
    texts = {path.relative_to(root / "src").as_posix(): path.read_text(encoding="utf-8")
             for path in files(root, ["src"], {".hpp", ".cpp"})}
    return {name: {header for header in INCLUDE.findall(text) if header in texts}
            for name, text in texts.items()}


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Sets of two or more nodes that all reach each other (strongly connected components)."""
    number: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        number[node] = lowest[node] = len(number)
        stack.append(node)
        for target in sorted(graph.get(node, ())):
            if target not in number:
                visit(target)
            if target in stack:
                lowest[node] = min(lowest[node], lowest[target])
        if lowest[node] == number[node]:
            component = stack[stack.index(node):]
            del stack[-len(component):]
            if len(component) > 1:
                found.append(sorted(component))

    for node in sorted(graph):
        if node not in number:
            visit(node)
    return sorted(found)


def unit(name: str) -> str:
    return name.rpartition(".")[0]


def faults(root: Path) -> dict[str, str]:
    """Short name of a fault -> its sentence. Short names have no folders, so files may move."""
    graph = includes(root)
    headers = {name: targets for name, targets in graph.items() if name.endswith(".hpp")}
    units = defaultdict(set)
    clients = defaultdict(set)
    for name, targets in graph.items():
        for target in targets:
            units[unit(name)].add(unit(target))
            if unit(target) != unit(name):
                clients[target].add(name)
    found = {}

    def circle(kind: str, circle: list[str]) -> None:
        short = " ".join(sorted(Path(name).name for name in circle))
        found[f"{kind} {short}"] = f"src: {', '.join(circle)} include each other in a circle"

    for each in circles(headers):
        circle("headers", each)
    for each in circles(units):
        circle("units", each)
    for header in headers:
        short = Path(header).name
        if not clients[header]:
            found[f"unused {short}"] = f"src/{header}: no other file of src/ includes it"
    return found


def accepted(file: Path) -> list[str]:
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    return [line for line in lines if line and not line.startswith("#")]


def is_accepted(short: str, known: list[str]) -> bool:
    """Whether the list contains the fault, or a larger circle of which the fault is a part."""
    kind, *members = short.split()
    return short in known or (kind in ("headers", "units") and any(
        entry.split()[0] == kind and set(members) < set(entry.split()[1:]) for entry in known))


def new_faults(root: Path, file: Path = ACCEPTED, most: int = MOST_ACCEPTED) -> list[str]:
    """The faults that are not accepted, including a list that has grown."""
    known = accepted(file)
    broken = [text for short, text in faults(root).items() if not is_accepted(short, known)]
    if len(known) > most:
        broken.append(f"{file.name}: {len(known)} exceptions, at most {most}: mend the fault instead")
    return broken


def shrink(root: Path, file: Path = ACCEPTED) -> int:
    """Removes mended faults from the list; returns the number of the remaining ones."""
    comments = [line for line in file.read_text(encoding="utf-8").splitlines()
                if line.startswith("#")]
    known = accepted(file)
    left = [short for short in faults(root) if is_accepted(short, known)]
    file.write_text("\n".join([*comments, *sorted(left)]) + "\n", encoding="utf-8")
    return len(left)


if __name__ == "__main__":
    tree = Path(sys.argv[1])
    if "--shrink" in sys.argv:
        print(f"{shrink(tree)} exceptions are left; set MOST_ACCEPTED to that number")
        sys.exit(0)
    wrong = new_faults(tree)
    mended = set(accepted(ACCEPTED)) - set(faults(tree))
    if mended:
        print(f"{len(mended)} accepted faults have gone; includes.py ROOT --shrink updates the list")
    print("\n".join(wrong) or "no circles of headers and no unused header are new")
    sys.exit(1 if wrong else 0)
