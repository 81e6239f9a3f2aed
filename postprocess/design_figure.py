# SPDX-License-Identifier: BSD-3-Clause
"""Where a study leaves the laws of one lightly damped mode: maps over (Y, β)."""
from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from culm_archive import Study
from figure_style import BLACK, COLOUR_MAP, GREY, FigureSkipped, mark, new_figure, styled
from study_points import StudyPoints, conditions, fitted_points, other_factors

# The frequency is compared with that of the points of the lowest tenth of β.
LOW_DAMPING_QUANTILE = 0.1
# A design is drawn as cells if at least this share of all combinations of its levels has an answer.
SMALLEST_SHARE_OF_GRID = 0.5
FEWEST_LEVELS_FOR_CONTOURS = 4


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
    """Borders half-way between levels, (levels + 1); the outer cells reach as far out as in, but
    not below 0: neither Y nor β is negative."""
    middles = 0.5 * (levels[1:] + levels[:-1])
    first = max(0.0, 2.0 * levels[0] - middles[0])
    last = 2.0 * levels[-1] - middles[-1]
    return np.concatenate([[first], middles, [last]])


def draw_contours(axes, moduli: np.ndarray, dampings: np.ndarray, cells: np.ndarray):
    """Labelled lines, white on the dark half of the colour map and black on the bright one; none
    where they would break off at a cell without an answer or pretend a resolution."""
    if np.ma.is_masked(cells) or min(cells.shape) < FEWEST_LEVELS_FOR_CONTOURS:
        return
    low, high = cells.min(), cells.max()
    levels = [x for x in MaxNLocator(6).tick_values(low, high) if low < x < high]
    if not levels:
        return
    colours = ["white" if x < low + 0.6 * (high - low) else BLACK for x in levels]
    lines = axes.contour(
        1e-9 * moduli, dampings, cells, levels, colors=colours, linewidths=0.7, linestyles="solid"
    )
    axes.clabel(lines, fontsize=6)


def draw_map(axes, points: StudyPoints, values: np.ndarray):
    """Cells for a factorial design, else the points themselves."""
    grid = grid_of(points, values)
    if grid is None:
        return axes.scatter(
            1e-9 * points.youngs_modulus, points.damping, c=values, cmap=COLOUR_MAP, s=18
        )
    moduli, dampings, cells = grid
    axes.set_facecolor(GREY)  # what a cell without an answer shows
    mesh = axes.pcolormesh(
        1e-9 * edges_between(moduli), edges_between(dampings), cells, cmap=COLOUR_MAP
    )
    draw_contours(axes, moduli, dampings, cells)
    return mesh


def require_map(study: Study, points: StudyPoints):
    """FigureSkipped, with the reason, if the figure would mean nothing."""
    others = other_factors(study)
    if others:
        raise FigureSkipped(f"b2/√Y depends on more than Y and β here ({', '.join(others)}).")
    for values, name in ((points.youngs_modulus, "Young's modulus"), (points.damping, "damping")):
        if np.unique(values).size < 2:
            raise FigureSkipped(f"the bond {name} does not vary among the fitted points.")
    if points.damping.min() <= 0.0:
        raise FigureSkipped("the design holds undamped bonds, for which b1/β has no meaning.")


@styled
def design_figure(study: Study):
    """Maps over Y and β of (a) the deviation of b2/√Y from its value at low β and (b) −b1/β: both
    are constant where the motion is one lightly damped mode, as Eq. 1 assumes.

    FigureSkipped unless Y and β, and nothing else, vary and β is positive.
    """
    points = fitted_points(study)
    require_map(study, points)
    figure = new_figure(2.8, conditions(study))
    all_axes = figure.subplots(1, 2, sharey=True)
    quantities = (
        (frequency_deviation_percent(points), r"$b_2/\sqrt{Y}$ against its value at low β (%)"),
        (decay_per_damping(points), r"$-b_1/\beta$ ($10^{-3}$ per cycle)"),
    )
    for letter, axes, (values, label) in zip("ab", all_axes, quantities):
        shown = draw_map(axes, points, values)
        bar = figure.colorbar(shown, ax=axes, label=label, aspect=30, pad=0.02)
        bar.outline.set_linewidth(0.6)
        axes.set_xlabel("Bond Young's modulus $Y$ (GPa)")
        mark(axes, letter)
    all_axes[0].set_ylabel("Bond damping β (–)")
    return figure
