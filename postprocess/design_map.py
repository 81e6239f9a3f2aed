# SPDX-License-Identifier: BSD-3-Clause
"""The values of the maps over (Y, β) and the cells of a factorial design; draws nothing."""
from __future__ import annotations

import numpy as np

from culm.archive import Study
from study_points import StudyPoints, other_factors

# The frequency is compared with that of the points of the lowest tenth of β.
LOW_DAMPING_QUANTILE = 0.1
# A design is drawn as cells if at least this share of all combinations of its levels has an answer.
SMALLEST_SHARE_OF_GRID = 0.5


def frequency_deviation_percent(points: StudyPoints) -> np.ndarray:
    """b2/√Y against its median at low β, per cent; (M). One undamped mode has one b2/√Y."""
    ratio = points.frequency / np.sqrt(points.youngs_modulus)
    is_low = points.damping <= np.quantile(points.damping, LOW_DAMPING_QUANTILE)
    return 100.0 * (ratio / np.median(ratio[is_low]) - 1.0)


def decay_per_damping(points: StudyPoints) -> np.ndarray:
    """−b1/β in 1e-3, b1 per cycle; (M). One lightly damped mode has one b1/β."""
    return -1e3 * points.decay_per_cycle / points.damping


def grid_of(points: StudyPoints, values: np.ndarray):
    """Levels of Y (Pa) and β, and the values as a masked array (levels of β, levels of Y); None if
    the points are not a factorial design. Cells without an answer are masked."""
    moduli, column = np.unique(points.youngs_modulus, return_inverse=True)
    dampings, row = np.unique(points.damping, return_inverse=True)
    cells = moduli.size * dampings.size
    has_repeats = np.unique(row * moduli.size + column).size != values.size
    if has_repeats or values.size < SMALLEST_SHARE_OF_GRID * cells:
        return None
    grid = np.ma.masked_all((dampings.size, moduli.size))
    grid[row, column] = values
    return moduli, dampings, grid


def edges_between(levels: np.ndarray) -> np.ndarray:
    """Borders half-way between levels, (levels + 1). The outer cells are symmetric about their
    levels but do not extend below 0, because neither Y nor β is negative."""
    middles = 0.5 * (levels[1:] + levels[:-1])
    first = max(0.0, 2.0 * levels[0] - middles[0])
    last = 2.0 * levels[-1] - middles[-1]
    return np.concatenate([[first], middles, [last]])


def map_obstacle(study: Study, points: StudyPoints) -> str:
    """The reason why maps over (Y, β) are meaningless; empty if they are meaningful."""
    others = other_factors(study)
    if others:
        return f"b2/√Y depends on more than Y and β here ({', '.join(others)})."
    for values, name in ((points.youngs_modulus, "Young's modulus"), (points.damping, "damping")):
        if np.unique(values).size < 2:
            return f"the bond {name} does not vary among the fitted points."
    if points.damping.min() <= 0.0:
        return "the design holds undamped bonds, for which b1/β has no meaning."
    return ""
