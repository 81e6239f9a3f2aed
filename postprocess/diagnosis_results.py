# SPDX-License-Identifier: BSD-3-Clause
"""Reads what `culm diagnose` writes: diagnosis.json of -o DIR, or the file of --json."""
from __future__ import annotations

from pathlib import Path

from json_document import read_document


class DiagnosisError(Exception):
    """The file does not hold what it should; one sentence."""


class Diagnosis:
    """`content` is the document (docs/schemas/diagnosis.schema.json)."""

    def __init__(self, path):
        path = Path(path)
        self.file = path / "diagnosis.json" if path.is_dir() else path
        self.content = read_document(self.file, "diagnose", "diagnosis", DiagnosisError)

    @property
    def heading(self) -> str:
        """"T2: effect, quadratic_drag"."""
        effects = " and ".join(self.content["effects"])
        return f"{self.content['measurement']}: {self.content['verdict']}" + (
            f", {effects}" if effects else "")

    @property
    def visible_spots(self) -> list[dict]:
        """Blind spots with a size from which on they would show."""
        return [spot for spot in self.content["blind_spots"]
                if "failure" not in spot and not spot["beyond_bounds"]
                and spot["smallest_visible"]["value"] is not None]
