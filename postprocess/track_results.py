# SPDX-License-Identifier: BSD-3-Clause
"""Reads the folder that `culm track -o DIR` writes: track.json and deflection.csv."""
from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np


class TrackError(Exception):
    """The folder does not hold what it should; one sentence."""


class TrackResults:
    """`content` is track.json (docs/tracking.md); times in s from the release on, heights and
    deflections (T, H) in mm, NaN where nothing was seen."""

    def __init__(self, directory):
        self.directory = Path(directory)
        try:
            self.content = json.loads((self.directory / "track.json").read_text(encoding="utf-8"))
            self.stem = self.content["stem"]
            self.time_s, self.heights_mm, self.deflection_mm = _deflections(
                self.directory / "deflection.csv")
        except OSError as error:
            raise TrackError(f"{error.filename}: {error.strerror}.") from error
        except (ValueError, KeyError, TypeError, IndexError) as error:
            raise TrackError(f"{self.directory}: not readable as a tracked recording: "
                             f"{error}.") from error


def _deflections(file: Path):
    with file.open(newline="", encoding="utf-8") as lines:
        header, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
    return values[:, 0], [float(name[2:-2]) for name in header[1:]], values[:, 1:]
