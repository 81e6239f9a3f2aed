# SPDX-License-Identifier: BSD-3-Clause
"""The files of the source tree that the style tests check."""

from pathlib import Path

GENERATED = {"build", "results", "__pycache__", ".git"}


def files(root: Path, folders: list[str], suffixes: set[str]) -> list[Path]:
    """Files below the folders that end in one of the suffixes, sorted; folders may be missing."""
    found = []
    for folder in folders:
        for path in sorted((root / folder).rglob("*")):
            generated = GENERATED.intersection(path.relative_to(root).parts)
            if path.is_file() and path.suffix in suffixes and not generated:
                found.append(path)
    return found
