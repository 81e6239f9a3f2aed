# SPDX-License-Identifier: BSD-3-Clause
"""Averages a record down that is sampled far faster than its stem swings: more than 60 readings per
cycle of the second mode cost time and tell nothing. A mean over a 60th of a cycle is 0.05 % smaller
than the middle value."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from recording.columns import usual_half_swing
from recording.mapping_file import Mapping
from recording.recorded_table import Assumption
from recording.refusal import Refusal

if TYPE_CHECKING:
    from recording.measured_rows import Measured

ENOUGH_PER_CYCLE = 60.0 * 6.267  # of the first mode; the second is (4.6941/1.8751)² as fast
MOST_UNAVERAGED = 20_000  # fewer readings cost little


def readings_per_cycle(measured: Measured) -> float:
    """Of the row that swings slowest: elsewhere a higher mode may dominate. The large first swings
    count, as the last ones may be lost in the noise."""
    swing = slice(int(np.searchsorted(measured.times, measured.release)), None)
    return max((2.0 * usual_half_swing(row.values[swing]) for row in measured.rows
                if np.any(np.isfinite(row.values[swing]))), default=0.0)


def smooth_number(most: int) -> int:
    """The largest number without prime factors above 5, of which a Fourier transform is fast."""
    return max(2 ** int(math.log2(most / odd)) * odd
               for odd in (3 ** i * 5 ** k for i in range(40) for k in range(30)) if odd <= most)


def means(values: np.ndarray, size: int) -> np.ndarray:
    """Of groups; a gap where fewer than half of a group's readings are known."""
    groups = values.reshape(-1, size)
    known = np.isfinite(groups)
    count = known.sum(axis=1)
    total = np.where(known, groups, 0.0).sum(axis=1)
    return np.where(2 * count >= size, total / np.maximum(count, 1), np.nan)


def average_down(measured: Measured, mapping: Mapping):
    """Groups do not contain the release. A stated noise becomes that of the means."""
    count, size = len(measured.times), mapping.readings_per_mean
    per_cycle = readings_per_cycle(measured)
    if size is None:
        size = int(per_cycle // ENOUGH_PER_CYCLE) if count > MOST_UNAVERAGED else 1
    if size < 2:
        return
    release = int(np.searchsorted(measured.times, measured.release))
    if (count - release) // size < 12:
        raise Refusal(f"[time] readings_per_mean = {size} leaves fewer than 12 means")
    kept = slice(release % size, release + size * smooth_number((count - release) // size))
    measured.times = means(measured.times[kept], size)
    stated = mapping.document.get("measurement", {})
    for key in [key for key in stated if key in ("noise_mm", "noise_m")]:
        stated[key] /= math.sqrt(size)
    for row in measured.rows:
        row.values = means(row.values[kept], size)
        if row.noise is not None:
            row.noise /= math.sqrt(size)
    measured.assumptions.append(Assumption(
        f"{count} readings, {per_cycle:.4g} per cycle, are averaged in groups of {size}; a stated "
        "noise is divided by the root of that", "[time] readings_per_mean"))
