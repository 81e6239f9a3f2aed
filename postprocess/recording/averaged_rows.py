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


def errors_of_means(size: int, correlation: float) -> tuple[float, float]:
    """Standard deviation of a mean over that of a reading, and the correlation of neighbouring means,
    for errors with the correlation r^k between readings k apart."""
    r = correlation
    sums = (1.0 - r ** size) / (1.0 - r)
    variance = (size * (1.0 + r) - 2.0 * r * sums) / (1.0 - r) / size ** 2
    return math.sqrt(variance), r * (sums / size) ** 2 / variance


def scale_stated_noise(measured: Measured, mapping: Mapping, size: int):
    """In the tables that become stem.toml's, and in the rows."""
    stated = mapping.document.get("measurement", {})
    factor, correlation = errors_of_means(size, stated.get("noise_correlation", 0.0))
    if "noise_correlation" in stated:
        stated["noise_correlation"] = round(correlation, 6)
    for table in (stated, *mapping.sensors):
        for key in ("noise_mm", "noise_m", "noise"):
            if key in table:
                table[key] *= factor
    for key in ("noise_by_height_mm", "noise_by_height_m"):
        if key in stated:
            stated[key] = [factor * value for value in stated[key]]
    for row in measured.rows:
        if row.noise is not None:
            row.noise *= factor


def average_down(measured: Measured, mapping: Mapping):
    """Groups do not contain the release. A stated noise becomes that of the means."""
    count, size = len(measured.times), mapping.readings_per_mean
    if size == 1 or (size is None and count <= MOST_UNAVERAGED):
        return
    per_cycle = readings_per_cycle(measured)
    size = size or int(per_cycle // ENOUGH_PER_CYCLE)
    if size < 2:
        return
    release = int(np.searchsorted(measured.times, measured.release))
    if (count - release) // size < 12:
        raise Refusal(f"[time] readings_per_mean = {size} leaves fewer than 12 means")
    kept = slice(release % size, release + size * smooth_number((count - release) // size))
    measured.times = means(measured.times[kept], size)
    for row in measured.rows:
        row.values = means(row.values[kept], size)
    scale_stated_noise(measured, mapping, size)
    measured.assumptions.append(Assumption(
        f"{count} readings, {per_cycle:.4g} per cycle, are averaged in groups of {size}; a stated "
        "noise becomes that of the means", "[time] readings_per_mean"))
