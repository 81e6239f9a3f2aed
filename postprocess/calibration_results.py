# SPDX-License-Identifier: BSD-3-Clause
"""Reads the folder that `culm calibrate -o DIR` writes: calibration.json and predictions/NNN.csv."""
from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from json_document import read_document


class CalibrationError(Exception):
    """The folder does not hold what culm calibrate -o writes."""


class CalibrationResults:
    """calibration.json and the predictions beside it."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.content = read_document(folder / "calibration.json", "calibrate", "calibration",
                                     CalibrationError)
        self.stems = self.content["stems"]

    def prediction(self, stem_number: int):
        """Times in s; heights in mm; measured and predicted deflection (frames, heights) in mm."""
        file = self.folder / "predictions" / f"{stem_number:03}.csv"
        try:
            with file.open(encoding="utf-8") as lines:
                names, *rows = csv.reader(lines)
        except (OSError, ValueError) as error:
            raise CalibrationError(f"{file} cannot be read: {error}") from None
        table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
        heights = [float(name.split("h=")[1][:-2]) for name in names[1::2]]
        return table[:, 0], heights, table[:, 1::2], table[:, 2::2]
