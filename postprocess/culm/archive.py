# SPDX-License-Identifier: BSD-3-Clause
"""Reads the result folder of a study: `study.h5` (docs/archive-format.md) and `summary.json`.

    from culm import Study

    with Study("results/schramm2019") as study:
        study.factor_names                      # ['bond_damping', 'bond_youngs_modulus_gpa']
        frequency = study["frequency"]          # (points), Hz; NaN where there is no answer
        study.unit("frequency")                 # 'Hz'
        study.table()                           # all columns as a pandas DataFrame
        y = study.tip_deflection(0)             # (samples), m, at the times study.time

Shapes: P points, S samples, H heights, N spheres. Arrays are read on access, as float64.
"""
from __future__ import annotations

import difflib
import json
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from culm.checked_hdf5 import CheckedFile, StudyError, sentence

__all__ = ["Failure", "Study", "StudyError"]


class Failure(NamedTuple):
    """A point whose computation failed."""

    point: int
    kind: str
    reason: str


class Study:
    """The results of one study, open for reading; close it, or use it in a `with` statement.

    `directory` is the result folder (or its study.h5). Raises StudyError if the folder contains no
    archive, or one of another format or of an unknown major version. Reading damaged data raises
    StudyError: the checksums of the file prevent wrong numbers.
    """

    def __init__(self, directory):
        given = Path(directory)
        is_file = given.is_file() or given.suffix == ".h5"
        self.directory = given.parent if is_file else given
        self.path = given if is_file else given / "study.h5"
        self._file = self._open()
        try:
            self._factor_names = self._file.text_list("design", "columns")
            self._result_names = self._file.text_list("results", "columns")
            self._points = int(self._file.attribute("/", "points"))
            self._statuses = self._read_statuses()
        except BaseException:
            self.close()
            raise

    def close(self):
        """Closes the file; arrays that were read remain valid."""
        self._file.file.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def __repr__(self):
        if not self._file.file:
            return f"<Study {self.path}, closed>"
        completed = int(self.is_completed.sum())
        return (
            f"<Study {self.path}: {completed} of {self.points} points completed; "
            f"factors: {', '.join(self.factor_names) or 'none'}>"
        )

    # -- what is in the file ------------------------------------------------------------------

    @property
    def points(self) -> int:
        """P, the number of points in the design; their ids are 0 … P − 1."""
        return self._points

    @property
    def spheres(self) -> int:
        """N, spheres in the chain; 0 if the study does not state it."""
        return int(self._file.attribute("/", "spheres"))

    @property
    def factor_names(self) -> list[str]:
        """The factors in their order, named by the keys of the study's configuration."""
        return list(self._factor_names)

    @property
    def result_names(self) -> list[str]:
        """The result columns in their order."""
        return list(self._result_names)

    def unit(self, name: str) -> str:
        """Unit of a factor or result column; "1" if dimensionless."""
        return str(self._file.attribute(self._column_path(name), "unit"))

    def description(self, name: str) -> str:
        """Description of a factor or result column; empty if the file has none."""
        return str(self._file.dataset(self._column_path(name)).attrs.get("description", ""))

    def _ipython_key_completions_(self):
        return self._factor_names + self._result_names

    # -- tables -------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> np.ndarray:
        """A factor or result column, (P), in its unit; results are NaN unless completed.

        A factor takes precedence over a result of the same name. Raises StudyError, which names the
        nearest column, if there is no such column.
        """
        return self._file.read(self._column_path(name))

    def __contains__(self, name: str) -> bool:
        return name in self._factor_names or name in self._result_names

    @property
    def factors(self) -> dict[str, np.ndarray]:
        """All factor columns by name, each (P) in its unit."""
        return {name: self._file.read(f"design/{name}") for name in self._factor_names}

    @property
    def results(self) -> dict[str, np.ndarray]:
        """All result columns by name, each (P) in its unit; NaN unless completed."""
        return {name: self._file.read(f"results/{name}") for name in self._result_names}

    def table(self):
        """Status, factors and results of every point: a pandas DataFrame with the points as its
        index (units in `attrs["units"]`) where pandas is installed, else a dict of arrays (P)."""
        columns = {"status": self.statuses, **self.results, **self.factors}
        order = ["status", *self._factor_names, *self._result_names]
        columns = {name: columns[name] for name in dict.fromkeys(order)}
        try:
            import pandas
        except ImportError:
            return columns
        frame = pandas.DataFrame(columns, index=pandas.RangeIndex(self.points, name="point"))
        frame.attrs["units"] = {name: self.unit(name) for name in columns if name != "status"}
        return frame

    def parameter(self, key: str) -> np.ndarray:
        """A parameter of the stem or the release at every point, (P), in the unit of its key.

        A constant of the study is repeated for every point. Raises StudyError if the study states
        no such number.
        """
        if key in self._factor_names:
            return self._file.read(f"design/{key}")
        settings = self.settings
        for section in ("stem", "release"):
            try:
                return np.full(self.points, float(settings[f"{section}.{key}"]))
            except (KeyError, ValueError):
                continue
        raise StudyError(f"{self.path}: the study states no number for '{key}'.")

    @property
    def statuses(self) -> np.ndarray:
        """State of every point, (P) of str: "completed", "failed" or "missing" (not computed)."""
        return self._statuses.copy()

    @property
    def is_completed(self) -> np.ndarray:
        """(P) of bool."""
        return self._statuses == "completed"

    @property
    def failures(self) -> list[Failure]:
        """The failed points with the reason of each, by rising id."""
        kinds = self._file.read("results/failure_kind")
        reasons = self._file.read("results/failure_reason")
        failed = np.flatnonzero(self._statuses == "failed")
        return [Failure(int(p), str(kinds[p]), str(reasons[p])) for p in failed]

    # -- histories ----------------------------------------------------------------------------

    @property
    def stores_tip(self) -> bool:
        return "histories/tip_deflection" in self._file

    @property
    def stores_heights(self) -> bool:
        return "histories/height_deflection" in self._file

    @property
    def stores_positions(self) -> bool:
        return "particles" in self._file

    @property
    def time(self) -> np.ndarray:
        """Times of the samples, (S), s; 0 is the release."""
        return self._history("time")

    @property
    def heights(self) -> np.ndarray:
        """Heights above the clamp at which the deflection is stored, (H), m."""
        return self._history("heights")

    def tip_deflection(self, point: int) -> np.ndarray:
        """Lateral deflection of the tip of a completed point, (S), m."""
        self._require_completed(point)
        return self._history("tip_deflection", np.s_[int(point)])

    def height_deflection(self, point: int) -> np.ndarray:
        """Lateral deflection at `heights` of a completed point, (S, H), m."""
        self._require_completed(point)
        return self._history("height_deflection", np.s_[int(point)])

    def positions(self, point: int) -> np.ndarray:
        """Sphere centres of a completed point, (S, N, 3), m: axial, lateral, out of plane."""
        self._require_completed(point)
        if not self.stores_positions:
            raise StudyError(f"{self.path}: the study does not store positions.")
        places = "histories/trajectory_place"
        if places in self._file:
            place = self._file.read(places, int(point))
            if place[0] >= 0:
                return self._file.trajectory(*place)
        values = self._file.read(f"particles/point_{int(point):06d}/position/value")
        return values.astype(np.float64)

    @property
    def position_bytes(self) -> int:
        """Bytes of a stored coordinate: 8, or 4 with `archive.trajectory_precision = "float32"`."""
        precision = self._file.file.attrs.get("trajectory_precision", "float64")
        return 4 if precision == "float32" else 8

    # -- provenance ---------------------------------------------------------------------------

    @property
    def provenance(self) -> dict[str, str]:
        """Compiler, libraries, hosts, seeds, start, end, config … as text, in the file's order."""
        names = self._file.text_list("provenance", "entries")
        return {
            name: self._file.text(f"provenance/{name}")
            if f"provenance/{name}" in self._file
            else str(self._file.attribute("provenance", name))
            for name in names
        }

    @property
    def settings(self) -> dict[str, str]:
        """Every value that influences the results, after defaults, as text in config units.

        These are the `key = value` lines of the study's identity: `law.name`, `reduce.window_s`,
        `stem.density_kg_m3` …
        """
        lines = self._file.text("provenance/identity").splitlines()
        return dict(line.split(" = ", 1) for line in lines if " = " in line)

    @property
    def summary(self) -> dict:
        """The content of summary.json, written by `culm reduce`."""
        path = self.directory / "summary.json"
        try:
            summary = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise StudyError(f"{path} does not exist; 'culm reduce' writes it.") from None
        except (OSError, ValueError) as error:
            raise StudyError(f"{path} cannot be read: {sentence(error)}") from error
        if not isinstance(summary, dict):
            raise StudyError(f"{path} is not the summary of a study: it holds no JSON object.")
        return summary

    # -- private ------------------------------------------------------------------------------

    def _open(self) -> CheckedFile:
        if not self.directory.is_dir():
            raise StudyError(f"{self.directory} is not a folder.")
        if not self.path.is_file():
            raise StudyError(
                f"{self.path} does not exist; 'culm run' writes it when a study ends or stops."
            )
        return CheckedFile(self.path)

    def _column_path(self, name: str) -> str:
        if name in self._factor_names:
            return f"design/{name}"
        if name in self._result_names:
            return f"results/{name}"
        known = self._factor_names + self._result_names
        nearest = difflib.get_close_matches(str(name), known, n=1, cutoff=0.0)
        hint = f"; the nearest is '{nearest[0]}'" if nearest else ""
        raise StudyError(f"{self.path} has no column '{name}'{hint}.")

    def _read_statuses(self) -> np.ndarray:
        numbers = self._file.read("results/status")
        names = h5py.check_enum_dtype(self._file.dataset("results/status").dtype) or {}
        if numbers.shape != (self.points,) or not set(numbers.tolist()) <= set(names.values()):
            raise StudyError(f"{self.path}: /results/status does not hold a state for each point.")
        name_of = {number: name for name, number in names.items()}
        return np.array([name_of[number] for number in numbers.tolist()], dtype=np.str_)

    def _history(self, name: str, selection=()) -> np.ndarray:
        if f"histories/{name}" not in self._file:
            raise StudyError(f"{self.path}: the study does not store {name.replace('_', ' ')}.")
        return self._file.read(f"histories/{name}", selection)

    def _require_completed(self, point: int):
        if not 0 <= point < self.points:
            raise StudyError(f"{self.path}: point {point} is not one of 0 … {self.points - 1}.")
        status = self._statuses[point]
        if status != "completed":
            raise StudyError(f"{self.path}: point {point} has no history: it is {status}.")
