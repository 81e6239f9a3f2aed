# SPDX-License-Identifier: BSD-3-Clause
"""Maps over (Y, β) that show where a study departs from the laws of one lightly damped mode."""
from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from culm.archive import Study
from design_map import (decay_per_damping, edges_between, frequency_deviation_percent, grid_of,
                        map_obstacle)
from figure_style import FigureSkipped, mark, new_figure, styled
from palette import BLACK, COLOUR_MAP, GREY
from study_points import StudyPoints, conditions, fitted_points

FEWEST_LEVELS_FOR_CONTOURS = 4


def draw_contours(axes, moduli: np.ndarray, dampings: np.ndarray, cells: np.ndarray):
    """Labelled contours, white on the dark half of the colour map and black on the bright one; none
    if they would end at a cell without an answer or suggest a resolution that does not exist."""
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
    """Draws cells for a factorial design and points for any other design."""
    grid = grid_of(points, values)
    if grid is None:
        return axes.scatter(
            1e-9 * points.youngs_modulus, points.damping, c=values, cmap=COLOUR_MAP, s=18
        )
    moduli, dampings, cells = grid
    axes.set_facecolor(GREY)  # cells without an answer
    mesh = axes.pcolormesh(
        1e-9 * edges_between(moduli), edges_between(dampings), cells, cmap=COLOUR_MAP
    )
    draw_contours(axes, moduli, dampings, cells)
    return mesh


@styled
def design_figure(study: Study):
    """Maps over Y and β of (a) the deviation of b2/√Y from its value at low β and (b) −b1/β: both
    are constant where the motion is one lightly damped mode, as Eq. 1 assumes.

    Raises FigureSkipped unless only Y and β vary and β is positive.
    """
    points = fitted_points(study)
    obstacle = map_obstacle(study, points)
    if obstacle:
        raise FigureSkipped(obstacle)
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
