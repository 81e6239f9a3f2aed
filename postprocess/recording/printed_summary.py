# SPDX-License-Identifier: BSD-3-Clause
"""Prints what an import made: notes, frames, readings, and everything that was assumed."""
from __future__ import annotations

import sys
import textwrap
from pathlib import Path

import numpy as np

from recording.measured_rows import Measured, Row, two_digits
from recording.recorded_table import Assumption, counted

WIDTH = 100


def assumed_lines(assumptions: list[Assumption]) -> list[str]:
    """One block; each line names the key that overrides it."""
    if not assumptions:
        return []
    wrapped = [textwrap.wrap(str(assumption), WIDTH, initial_indent="  ",
                             subsequent_indent="    ", break_long_words=False)
               for assumption in assumptions]
    return ["assumed:", *(line for lines in wrapped for line in lines)]


def time_gaps_text(times: np.ndarray) -> str:
    """Gaps between frames that are longer than one and a half usual frame times."""
    steps = np.diff(times)
    usual = np.median(steps)  # a few gaps do not change it
    gaps = np.flatnonzero(steps > 1.5 * usual)
    if gaps.size == 0:
        return "no gap in time"
    longest = gaps[np.argmax(steps[gaps])]
    return (f"{counted(gaps.size, 'gap')} in time, the longest {1e3 * steps[longest]:.4g} ms at "
            f"{times[longest]:.6g} s")


def row_text(row: Row) -> str:
    what = "deflection" if row.sensor is None else row.sensor["quantity"]
    seen = np.abs(row.values[np.isfinite(row.values)])
    largest = f"{seen.max():.4g} {row.unit}" if seen.size else "none"
    noise = f"{two_digits(row.noise)} {row.unit}" if row.noise is not None else "unknown"
    return f"  h = {row.millimetres:g} mm: largest {what} {largest}, noise {noise}"


def print_measurement(folder: Path, measured: Measured):
    for note in measured.notes:
        print(f"culm: note: {note}", file=sys.stderr)
    missing = sum(int(np.sum(~np.isfinite(row.values))) for row in measured.rows)
    before = int(np.sum(measured.times < 0.0))
    print(f"{folder}: {counted(len(measured.rows), 'height')}, "
          f"{counted(len(measured.times), 'frame')} ({before} before the release), "
          f"{counted(missing, 'reading')} missing; {time_gaps_text(measured.times)}")
    for row in measured.rows:
        print(row_text(row))
    if measured.noise_source:
        print(f"  noise: {measured.noise_source}")
    for line in assumed_lines(measured.assumptions):
        print(line)
    print(f"\nnext: culm fit {folder}")
