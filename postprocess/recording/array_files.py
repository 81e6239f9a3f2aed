# SPDX-License-Identifier: BSD-3-Clause
"""Reads the arrays of MATLAB (.mat) and NumPy (.npy, .npz) files as columns.

A file may contain a whole workspace. The arrays of one recording have one length: that of the time
array. Spectra and other arrays of other lengths are named and not read."""
from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import numpy as np

from recording.recorded_table import Assumption, RecordedTable, StatedRate
from recording.refusal import Refusal

Arrays = list[tuple[str, np.ndarray]]
TIME_NAME = re.compile(r"(.*\.)?(t\d*|t_.*|time.*|zeit.*|frames?)", re.IGNORECASE)
RATE_NAME = re.compile(r"(.*\.)?(fs|f_s|fsamp\w*|sampl\w*rate|sample_?rate|fps|rate|sr)",
                       re.IGNORECASE)
INTERVAL_NAME = re.compile(r"(.*\.)?(dt|t_?s|delta_?t|interval)", re.IGNORECASE)


def arrays_in(name: str, value) -> Arrays:
    """Names and arrays, frames first, of a variable, its fields and its cells."""
    if isinstance(value, dict):
        return [found for field, part in value.items() for found in arrays_in(f"{name}.{field}", part)]
    if hasattr(value, "_fieldnames"):
        return [found for field in value._fieldnames
                for found in arrays_in(f"{name}.{field}", getattr(value, field))]
    if getattr(value, "dtype", None) == object:
        return [found for count, entry in enumerate(value.flat, 1)
                for found in arrays_in(f"{name} {count}", entry)]
    if isinstance(value, (int, float)):
        return [(name, np.array(value))]
    if getattr(getattr(value, "dtype", None), "kind", "") not in ("i", "u", "f"):
        return []
    value = np.squeeze(value)
    if value.ndim == 0:
        return [(name, value)]
    if value.ndim > 2 or min(value.shape) == 0:
        return []
    return [(name, value.T if value.ndim == 2 and value.shape[1] > value.shape[0] else value)]


def as_column(values: np.ndarray) -> np.ndarray:
    return values.astype(np.int64 if values.dtype.kind in "iu" else float)


def columns_of(name: str, values: np.ndarray) -> Arrays:
    if values.ndim == 1:
        return [(name or "1", as_column(values))]
    return [(f"{name} {k}".strip(), as_column(column)) for k, column in enumerate(values.T, 1)]


def ascends(values: np.ndarray) -> bool:
    return len(values) > 1 and bool(np.all(np.diff(values.astype(float)) > 0.0))


def chosen_length(columns: dict[int, Arrays], wanted: list[str]) -> int:
    """The length of the first wanted column, else of the longest with a time, else the one of most
    columns."""
    for name in wanted:
        for length, group in columns.items():
            if any(name == other for other, _ in group):
                return length
    timed = [length for length, group in columns.items()
             if any(TIME_NAME.fullmatch(name) and ascends(values) for name, values in group)]
    return max(timed or columns, key=lambda length: (0 if timed else len(columns[length]), length))


def begins_with_times(matrix: np.ndarray) -> bool:
    """Whether the first column ascends in equal steps."""
    if matrix.ndim != 2 or matrix.shape[1] < 2 or not ascends(matrix[:, 0]):
        return False
    steps = np.diff(matrix[:, 0].astype(float))
    return bool(np.ptp(steps) < 0.01 * np.median(steps))


def rate_among(scalars: Arrays) -> StatedRate | None:
    for pattern, is_rate in ((RATE_NAME, True), (INTERVAL_NAME, False)):
        for name, value in scalars:
            if pattern.fullmatch(name) and float(value) > 0.0:
                hertz = float(value) if is_rate else 1.0 / float(value)
                return StatedRate(hertz, f'the variable "{name}"')
    return None


def table_of_arrays(entries: dict, wanted: list[str]) -> RecordedTable:
    found = [array for name, value in entries.items() for array in arrays_in(name, value)]
    groups: dict[int, Arrays] = defaultdict(list)
    for name, values in found:
        if values.ndim > 0 and len(values) > 1:
            groups[len(values)] += columns_of(name, values)
    if not groups:
        has = ", ".join(f"{name:.40} ({getattr(value, 'dtype', type(value).__name__)}, shape "
                        f"{getattr(value, 'shape', ())})" for name, value in list(entries.items())[:8])
        raise Refusal("no numeric array of one or two dimensions is in it, which is what is "
                      f"allowed; it has {has or 'nothing'}")
    length = chosen_length(groups, wanted)
    times = [c for c in groups[length] if TIME_NAME.fullmatch(c[0]) and ascends(c[1])]
    rest = [c for c in groups[length] if all(c is not time for time in times)]
    if not times and not any(begins_with_times(array) for _, array in found
                             if array.ndim > 0 and len(array) == length):
        times = [("frame", np.arange(length))]
    columns = times + rest
    repeated = sorted({name for name, _ in columns if [n for n, _ in columns].count(name) > 1})
    if repeated:
        raise Refusal(f"two columns would be named '{repeated[0]}'; different names are allowed")
    table = RecordedTable([name for name, _ in columns], [values for _, values in columns],
                          rate=rate_among([a for a in found if a[1].ndim == 0]))
    others = {n: group for n, group in groups.items() if n != length}
    if others:
        listed = "; ".join(f"{', '.join(name for name, _ in group[:8])} ({n} values)"
                           for n, group in sorted(others.items()))
        table.assumptions.append(Assumption(
            f"the arrays of {length} values are the recording; others are not read: {listed}",
            "[time] column"))
    return table


def matlab_hdf5(source: Path) -> dict:
    """The numeric datasets of a MATLAB file of version 7.3, which is HDF5; MATLAB's columns are
    stored as rows."""
    import h5py

    def content(group) -> dict:
        found = {}
        for name, item in group.items():
            if name.startswith("#"):
                continue
            if isinstance(item, h5py.Group):
                found[name] = content(item)
            elif item.dtype.kind in "iuf" and item.attrs.get("MATLAB_class", b"") != b"char":
                found[name] = item[()].T
        return found
    try:
        with h5py.File(source, "r") as file:
            return content(file)
    except OSError as error:
        raise Refusal(f"it is not a whole MATLAB file of version 7.3 ({error}); save it again or "
                      "with -v7") from None


def matlab_table(source: Path, wanted: list[str]) -> RecordedTable:
    import h5py
    from scipy.io import loadmat
    if h5py.is_hdf5(source):
        return table_of_arrays(matlab_hdf5(source), wanted)
    with source.open("rb") as stream:
        try:
            entries = loadmat(stream, squeeze_me=True, struct_as_record=False)
        except Exception as error:  # scipy raises many kinds for a damaged file
            raise Refusal(f"it is not a whole MATLAB file ({error!r}); save it with -v7") from None
    return table_of_arrays({k: v for k, v in entries.items() if not k.startswith("__")}, wanted)


def numpy_table(source: Path, wanted: list[str]) -> RecordedTable:
    """pyidi's displacements (points, frames, 2) in pixels become `point 1 y`, `point 1 x`, …; pyidi
    saves results.pkl, whose array numpy.save writes as .npy."""
    with source.open("rb") as stream:
        try:
            loaded = np.load(stream, allow_pickle=False)
            entries = {name: loaded[name] for name in getattr(loaded, "files", ())}
        except Exception as error:  # numpy and zipfile raise many kinds for a damaged file
            raise Refusal(f"it is not a whole NumPy file of numbers ({error!r}); arrays that "
                          "numpy.save or numpy.savez wrote without pickle are allowed") from None
    if hasattr(loaded, "files") or loaded.ndim != 3:
        return table_of_arrays(entries or {"": loaded}, wanted)
    if loaded.shape[2] != 2 or loaded.dtype.kind not in "iuf" or loaded.size == 0:
        raise Refusal(f"its shape is {loaded.shape} of {loaded.dtype}; numbers of shape (points, "
                      "frames, 2) are allowed")
    columns = [(f"point {point} {axis}", as_column(values[:, k]))
               for point, values in enumerate(loaded, 1) for k, axis in enumerate("yx")]
    columns.insert(0, ("frame", np.arange(loaded.shape[1])))
    return RecordedTable([name for name, _ in columns], [values for _, values in columns])
