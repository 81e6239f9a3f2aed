#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Converts a recording to a CSV table for `culm import`: recording_table.py SOURCE --output TABLE.

.trk  Project of the video program Tracker: `t` in s and, of each point mass, `NAME x`, `NAME y` in
      the unit of the project's scale (m by default; pixels if the project has no calibration).
.c3d  Optical motion capture: `t` in s from the first frame and, of each marker, `LABEL x`,
      `LABEL y` and `LABEL z` in m.
.mat  MATLAB, not version 7.3: the numeric arrays of the most common length, also in structs.
.npz  NumPy: the same arrays.
.npy  NumPy: pyidi's displacements (points, frames, 2) in pixels become `point 1 y`, `point 1 x`, …;
      other arrays `1`, `2`, …. pyidi saves results.pkl; numpy.save writes its array as .npy.

Arrays without a time array (`t`, `time`) get a column `frame` counted from 0. An empty cell is a
gap. `--then WORD...`, which is last, replaces the program by this command line after success.
Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

import argparse
import csv
import io
import os
import re
import sys
from collections import Counter
from pathlib import Path

from c3d_recording import c3d_table
from needed_packages import require
from recording_refusal import Refusal, Table, exit_code_of
from report import write_whole
from tracker_project import tracker_table


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, usage="%(prog)s SOURCE --output TABLE [--then WORD...]",
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", metavar="SOURCE", type=Path)
    parser.add_argument("-o", "--output", metavar="TABLE", type=Path, required=True)
    parser.add_argument("--then", metavar="WORD", nargs=argparse.REMAINDER, default=[],
                        help="after success, become this command line (its first word is a path)")
    return parser.parse_args(arguments)


def arrays_in(name: str, value) -> list:
    """Names and arrays, frames first, of a variable, its fields and its cells."""
    if hasattr(value, "_fieldnames"):
        return [found for field in value._fieldnames
                for found in arrays_in(f"{name}.{field}", getattr(value, field))]
    if getattr(value, "dtype", None) == object:
        return [found for count, entry in enumerate(value.flat, 1)
                for found in arrays_in(f"{name} {count}", entry)]
    if getattr(getattr(value, "dtype", None), "kind", "") not in ("i", "u", "f"):
        return []
    value = value.squeeze()
    if value.ndim not in (1, 2) or min(value.shape) == 0:
        return []
    return [(name, value.T if value.ndim == 2 and value.shape[1] > value.shape[0] else value)]


def columns_of(name: str, values) -> Table:
    if values.ndim == 1:
        return [(name or "1", values.tolist())]
    return [(f"{name} {k}".strip(), column.tolist()) for k, column in enumerate(values.T, 1)]


def columns_of_arrays(entries: dict) -> Table:
    found = [array for name, value in entries.items() for array in arrays_in(name, value)]
    if not found:
        has = ", ".join(f"{name} ({getattr(value, 'dtype', type(value).__name__)}, shape "
                        f"{getattr(value, 'shape', ())})" for name, value in entries.items())
        raise Refusal("no numeric array of one or two dimensions is in it, which is what is "
                      f"allowed; it has {has or 'nothing'}")
    lengths = Counter(len(values) for _, values in found)
    frames = max(lengths, key=lambda length: (lengths[length], length))
    return with_time_first([column for name, values in found if len(values) == frames
                            for column in columns_of(name, values)])


def with_time_first(table: Table) -> Table:
    times = [column for column in table
             if re.fullmatch(r"(.*\.)?(t|t_.*|time.*|frames?)", column[0], re.IGNORECASE)
             and all(a < b for a, b in zip(column[1], column[1][1:]))]
    rest = [column for column in table if column not in times]
    return (times or [("frame", list(range(len(table[0][1]))))]) + rest


def matlab_table(source: Path) -> Table:
    require("numpy", "scipy")
    from scipy.io import loadmat
    with source.open("rb") as stream:
        try:
            entries = loadmat(stream, squeeze_me=True, struct_as_record=False)
        except NotImplementedError:
            raise Refusal("it is of version 7.3; save it in MATLAB with -v7") from None
        except Exception as error:  # scipy raises many kinds for a damaged file
            raise Refusal(f"it is not a whole MATLAB file ({error!r}); save it with -v7") from None
    return columns_of_arrays({k: v for k, v in entries.items() if not k.startswith("__")})


def numpy_table(source: Path) -> Table:
    require("numpy")
    import numpy
    with source.open("rb") as stream:
        try:
            loaded = numpy.load(stream, allow_pickle=False)
            entries = {name: loaded[name] for name in getattr(loaded, "files", ())}
        except Exception as error:  # numpy and zipfile raise many kinds for a damaged file
            raise Refusal(f"it is not a whole NumPy file of numbers ({error!r}); arrays that "
                          "numpy.save or numpy.savez wrote without pickle are allowed") from None
    if hasattr(loaded, "files") or loaded.ndim != 3:
        return columns_of_arrays(entries or {"": loaded})
    if loaded.shape[2] != 2 or loaded.dtype.kind not in "iuf" or loaded.size == 0:
        raise Refusal(f"its shape is {loaded.shape} of {loaded.dtype}; numbers of shape (points, "
                      "frames, 2) are allowed")
    return with_time_first([(f"point {point} {axis}", values[:, k].tolist())
                            for point, values in enumerate(loaded, 1)
                            for k, axis in enumerate("yx")])


READERS = {".trk": tracker_table, ".mat": matlab_table, ".npy": numpy_table, ".npz": numpy_table,
           ".c3d": c3d_table}


def table_text(table: Table) -> str:
    twice = [name for name, count in Counter(name for name, _ in table).items() if count > 1]
    if twice:
        raise Refusal(f"two columns would be named '{twice[0]}'; different names are allowed")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([name for name, _ in table])
    for row in zip(*(values for _, values in table)):
        writer.writerow(["" if value is None or value != value else
                         repr(value if isinstance(value, int) else float(value)) for value in row])
    return text.getvalue()


def convert(source: Path, output: Path, then: list[str]):
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise Refusal(f"its name does not end in one of {', '.join(READERS)}")
    write_whole(output, table_text(reader(source)))
    if then:
        os.execv(then[0], then)


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    return exit_code_of(options.source,
                        lambda: convert(options.source, options.output, options.then))


if __name__ == "__main__":
    sys.exit(main())
