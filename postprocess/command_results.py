# SPDX-License-Identifier: BSD-3-Clause
"""Reads the results of culm's commands: the JSON of calibrate, compare, diagnose, fit and track,
and the tables in the same folder. Every error message is one sentence."""
from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np


def read_document(file: Path, command: str, name: str, error_type: type[Exception],
                  version: int = 1) -> dict:
    """The document "culm-<name>" of `culm <command>`; error_type if another version wrote it."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise error_type(f"{file}: {error.strerror}.") from error
    except ValueError as error:
        raise error_type(f"{file}: not JSON: {error}.") from error
    if (not isinstance(content, dict) or content.get("format") != f"culm-{name}"
            or content.get("version") != version):
        raise error_type(f"{file}: not written by this version of culm {command}.")
    return content


class CalibrationError(Exception):
    """The folder does not contain the results of culm calibrate -o."""


class CalibrationResults:
    """calibration.json and the predictions in the same folder."""

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


class ComparisonError(Exception):
    """The file does not hold what it should; one sentence."""


class Comparison:
    """`content` is the document (culm schema comparison), `rungs` are the models of
    its ladder that could be fitted (docs/compare.md)."""

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


class DiagnosisError(Exception):
    """The file does not hold what it should; one sentence."""


def family_name(named: dict) -> str:
    """As the verdict names it: an effect, or its family and the likeliest laws."""
    members = " or ".join(named["members"])
    if len(named["members"]) == 1 and not named["by_family"]:
        return members
    return f"{named['family']} ({'most like ' if named['by_family'] else ''}{members})"


class Diagnosis:
    """`content` is the document (culm schema diagnosis)."""

    def __init__(self, path):
        path = Path(path)
        self.file = path / "diagnosis.json" if path.is_dir() else path
        self.content = read_document(self.file, "diagnose", "diagnosis", DiagnosisError, version=2)

    @property
    def heading(self) -> str:
        """"T3: effect, clamp_compliance", "T2: effect, air (most like quadratic_drag)"."""
        effects = " and ".join(map(family_name, self.content["alternatives"][0]["families"])
                               if self.content["effects"] else [])
        return f"{self.content['measurement']}: {self.content['verdict']}" + (
            f", {effects}" if effects else "")

    @property
    def visible_spots(self) -> list[dict]:
        """Blind spots that have a detection limit."""
        return [spot for spot in self.content["blind_spots"]
                if "failure" not in spot and not spot["beyond_bounds"]
                and spot["smallest_visible"]["value"] is not None]


class LaboratoryError(Exception):
    """The file does not hold what it should; one sentence."""


class Laboratory:
    """`content` is the document (culm schema laboratory); `stems` are those that were
    diagnosed, `left_out` the others."""

    def __init__(self, folder: Path):
        self.file = Path(folder) / "laboratory.json"
        self.content = read_document(self.file, "diagnose", "laboratory", LaboratoryError)
        self.stems = [stem for stem in self.content["stems"] if not stem.get("failure")]
        self.left_out = [stem for stem in self.content["stems"] if stem.get("failure")]


# Schramm et al. (2019), Fig. 5: mean and standard deviation of 29 stems.
PUBLISHED_B1_PER_CYCLE = (-0.46, 0.17)
PUBLISHED_B2_HZ = (64.6, 21.2)


class FitError(Exception):
    """The folder does not hold what it should; one sentence."""


class FitResults:
    """`content` is fit.json; `stems` and `population` are its members (docs/fit-format.md)."""

    def __init__(self, directory):
        self.directory = Path(directory)
        content = read_document(self.directory / "fit.json", "fit", "fit", FitError)
        self.content = content
        self.stems = content["stems"]
        self.population = content["population"]

    def fitted(self) -> list[dict]:
        """The stems with at least one height that could be fitted."""
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


class TrackError(Exception):
    """The folder does not hold what it should; one sentence."""


class TrackResults:
    """`content` is track.json (docs/tracking.md); times are in s from the release, heights and
    deflections (T, H) in mm. Deflections are NaN where nothing was seen."""

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
