# SPDX-License-Identifier: BSD-3-Clause
"""Reads a recording of any kind as a table.

.trk, .trz   project of the video program Tracker: `t` in s and, of each point mass, `NAME x`, `NAME y`
             in the unit of the project's scale (m by default; pixels without a calibration)
.c3d         optical motion capture: `t` in s from the first frame; `LABEL x`, `LABEL y`, `LABEL z` in m
.mat         MATLAB, also of version 7.3: the numeric arrays of the recording, also in structs
.npz, .npy   NumPy; of pyidi's displacements (points, frames, 2) `point 1 y`, `point 1 x`, … in pixels
others       a table of text
"""
from __future__ import annotations

from pathlib import Path

import numpy as np

from recording.array_files import matlab_table, numpy_table
from recording.c3d_recording import c3d_table
from recording.recorded_table import RecordedTable
from recording.refusal import Refusal, Table
from recording.text_table import TextOptions, text_table
from recording.tracker_project import tracker_table

USUAL_UNITS = {".trk": "m", ".trz": "m"}  # of displacements whose names state none


def table_of_lists(columns: Table, has_markers: bool) -> RecordedTable:
    names = [name for name, _ in columns]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise Refusal(f"two columns would be named '{twice[0]}'; different names are allowed")
    return RecordedTable(names, [np.array([np.nan if v is None else v for v in values], float)
                                 for _, values in columns], has_markers=has_markers)


def recorded_table(source: Path, options: TextOptions, wanted: list[str]) -> RecordedTable:
    """`wanted` are the columns that a mapping names; they choose among the arrays of a workspace."""
    kind = source.suffix.lower()
    if kind == ".mat":
        return matlab_table(source, wanted)
    if kind in (".npy", ".npz"):
        return numpy_table(source, wanted)
    if kind == ".c3d":
        return table_of_lists(c3d_table(source), True)
    if kind in (".trk", ".trz"):
        return table_of_lists(tracker_table(source), False)
    if kind == ".pkl":
        raise Refusal("a pickled object may execute code when it is read; save its array with "
                      "numpy.save as .npy (.trk, .trz, .c3d, .mat, .npy, .npz and tables of text are read)")
    return text_table(source, options)
