# SPDX-License-Identifier: BSD-3-Clause
"""Reads what `culm compare` writes: comparison.json of -o DIR, or the file of --json."""
from __future__ import annotations

from pathlib import Path

from json_document import read_document


class ComparisonError(Exception):
    """The file does not hold what it should; one sentence."""


class Comparison:
    """`content` is the document (docs/schemas/comparison.schema.json), `rungs` are those of its ladder
    that could be fitted (docs/compare.md)."""

    def __init__(self, path):
        path = Path(path)
        self.file = path / "comparison.json" if path.is_dir() else path
        content = read_document(self.file, "compare", "comparison", ComparisonError)
        self.content = content
        self.measurement = content["measurement"]
        self.noise_mm = content.get("noise_mm")
        self.rungs = [rung for rung in content["ladder"] if "failure" not in rung]
        if not self.rungs:
            raise ComparisonError(f"{self.file}: no model could be fitted.")


def name_of(rung: dict) -> str:
    """"baseline + quadratic_drag"."""
    return " + ".join(rung["model"])


def numbers(values: list) -> list[float]:
    """Nulls become NaN, which figures leave out."""
    return [float("nan") if value is None else value for value in values]
