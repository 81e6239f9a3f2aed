# SPDX-License-Identifier: BSD-3-Clause
"""Reads the folder that `culm fit -o DIR` writes: fit.json and normalised/NNN.csv."""
from __future__ import annotations

import csv
from pathlib import Path

from json_document import read_document


# Schramm et al. (2019), Fig. 5: mean and standard deviation of 29 stems.
PUBLISHED_B1_PER_CYCLE = (-0.46, 0.17)
PUBLISHED_B2_HZ = (64.6, 21.2)


class FitError(Exception):
    """The folder does not hold what it should; one sentence."""


class FitResults:
    """`content` is fit.json, `stems` and `population` are its (docs/fit-format.md)."""

    def __init__(self, directory):
        self.directory = Path(directory)
        content = read_document(self.directory / "fit.json", "fit", "fit", FitError)
        self.content = content
        self.stems = content["stems"]
        self.population = content["population"]

    def fitted(self) -> list[dict]:
        """The stems of which some height could be fitted."""
        return [stem for stem in self.stems if "b2_hz" in stem]

    def normalised(self, number: int) -> tuple[list[float], dict[str, list[float]]]:
        """Cycles, and the deflections by height, of the stem with this number (from 0)."""
        file = self.directory / "normalised" / f"{number + 1:03d}.csv"
        try:
            with file.open(newline="", encoding="utf-8") as lines:
                header, *rows = csv.reader(lines)
        except OSError as error:
            raise FitError(f"{file}: {error.strerror}.") from error
        columns = [[float(cell) if cell else float("nan") for cell in column]
                   for column in zip(*rows)]
        return columns[0], dict(zip(header[1:], columns[1:]))


def heights_of(stem: dict) -> list[dict]:
    """The heights of a stem that could be fitted."""
    return [height for height in stem["heights"] if "failure" not in height]
