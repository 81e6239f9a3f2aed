# SPDX-License-Identifier: BSD-3-Clause
"""A block of numbers on a page: a function of the files of bench/results that returns Markdown."""
from __future__ import annotations

import re
from collections.abc import Callable, Iterable

Read = Callable[[str], dict | None]
BLOCKS: dict[str, Callable[[Read], str]] = {}


NOT_MEASURED = "*Not measured yet.*"


def block(name: str, *files: str, find: Callable[[Read, str], dict | None] | None = None):
    """Registers a function of these files as the block `name`, which says so if one is missing.
    `find` looks for a file in another way than by its name."""
    def register(function: Callable[..., str]):
        def made(read: Read) -> str:
            results = [find(read, file) if find else read(file) for file in files]
            return NOT_MEASURED if None in results else function(*results)
        BLOCKS[name] = made
        return function
    return register


def origin(result: dict) -> str:
    """Command, commit, date and machine of a file."""
    if "machine" not in result:
        return (f"`{result['command']}` printed this with commit {result['commit']}, an earlier "
                "version. It is not yet measured with this one.")
    machine = result["machine"]
    return (f"`{result['command']}`, commit {result['commit']}, {result['date']}: "
            f"{machine['processor']}, {machine['vectors']}, {machine['cores']} cores, load average "
            f"{machine['load'][0]} at the end.")


def table(header: Iterable[str], rows: Iterable[Iterable]) -> str:
    """Columns that begin with a digit are aligned to the right."""
    header, rows = list(header), [list(map(str, row)) for row in rows]
    right = [k > 0 and all(re.match(r"[\d−+-]?\d*|$", row[k])[0] or not row[k] for row in rows)
             for k in range(len(header))]
    lines = ["| " + " | ".join(header) + " |",
             "|" + "|".join("---:" if each else "---" for each in right) + "|"]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)
