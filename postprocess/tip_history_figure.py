# SPDX-License-Identifier: BSD-3-Clause
"""Tip histories with their fits of Eq. 1, chosen like those of the paper's Fig. 7."""
from __future__ import annotations

import numpy as np

from culm.archive import Study
from figure_style import FigureSkipped, leave_room_above, mark, new_figure, styled
from palette import BLACK, GREY, SERIES, number
from study_points import StudyPoints, conditions, fit_window, fitted_motion, fitted_points

DAMPING_OF_FIG_7A = 150.0
DAMPINGS_OF_FIG_7B = (25.0, 100.0, 200.0)
# A curve is shown until its fitted envelope has fallen to this share of the release.
SMALLEST_ENVELOPE = 0.01


def smallest_middle_largest(values: np.ndarray) -> list[float]:
    levels = np.unique(values)
    return [levels[0], levels[(levels.size - 1) // 2], levels[-1]]


def nearest_rows(points: StudyPoints, targets: list[tuple[float, float]]) -> list[int]:
    """Rows of the points nearest to each (Y in Pa, β), every row at most once, in that order.

    Distances are relative to the ranges of the design; the first of equals in (Y, β) is chosen.
    """
    modulus_range = np.ptp(points.youngs_modulus) or 1.0
    damping_range = np.ptp(points.damping) or 1.0
    order = np.lexsort((points.damping, points.youngs_modulus))
    rows: list[int] = []
    for modulus, damping in targets:
        distance = np.hypot(
            (points.youngs_modulus[order] - modulus) / modulus_range,
            (points.damping[order] - damping) / damping_range,
        )
        row = int(order[np.argmin(distance)])
        if row not in rows:
            rows.append(row)
    return rows


def rows_of_varied_modulus(points: StudyPoints) -> list[int]:
    """Fig. 7a: smallest, middle and largest Y, at the β nearest to 150."""
    moduli = smallest_middle_largest(points.youngs_modulus)
    return nearest_rows(points, [(modulus, DAMPING_OF_FIG_7A) for modulus in moduli])


def rows_of_varied_damping(points: StudyPoints) -> list[int]:
    """Fig. 7b: the largest Y at the β nearest to 25, 100 and 200, or at the smallest, middle and
    largest β if the nearest points are not three different ones."""
    largest = float(points.youngs_modulus.max())
    rows = nearest_rows(points, [(largest, damping) for damping in DAMPINGS_OF_FIG_7B])
    if len(rows) == len(DAMPINGS_OF_FIG_7B):
        return rows
    return nearest_rows(points, [(largest, d) for d in smallest_middle_largest(points.damping)])


def last_visible_time(study: Study, point: int) -> float:
    """Time at which the fitted envelope is SMALLEST_ENVELOPE, s; infinite if it does not decay."""
    decay_rate = study["decay_rate"][point]
    return np.log(SMALLEST_ENVELOPE) / decay_rate if decay_rate < 0.0 else np.inf


def draw_histories(axes, study: Study, points: StudyPoints, rows: list[int], labels: list[str]):
    """Histories over their initial value, with the fits as thin dashed lines on top."""
    time = study.time
    is_fitted = (time >= 0.0) & (time <= fit_window(study))
    for row, colour, label in zip(rows, SERIES, labels):
        point = int(points.id[row])
        tip = study.tip_deflection(point)
        fit = fitted_motion(study, point, time, tip)
        axes.plot(1e3 * time, tip / tip[0], color=colour, label=label)
        axes.plot(
            1e3 * time[is_fitted],
            fit[is_fitted] / tip[0],
            color=BLACK,
            linewidth=0.7,
            linestyle=(0, (3, 2)),
        )
    axes.lines[-1].set_label("Eq. 1, fitted")
    ends = [last_visible_time(study, int(points.id[row])) for row in rows]
    axes.set_xlim(1e3 * time[0], 1e3 * min(time[-1], max(ends)))
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=0)
    axes.set_xlabel("Time since the release (ms)")
    axes.legend(loc="upper right", ncols=2)


def labels_and_title(varied: np.ndarray, fixed: np.ndarray, describe, describe_fixed):
    """Legend entries, which state the parameters that differ, and a title for the common one."""
    if np.ptp(fixed) == 0.0:
        return [describe(value) for value in varied], describe_fixed(fixed[0])
    both = zip(varied, fixed)
    return [f"{describe(value)}, {describe_fixed(other)}" for value, other in both], ""


def describe_modulus(modulus: float) -> str:
    return f"$Y$ = {number(1e-9 * modulus, 3)} GPa"


def describe_damping(damping: float) -> str:
    return f"β = {number(damping, 3)}"


@styled
def tip_history_figure(study: Study):
    """Fig. 7: tip deflection over its initial value against time with the fits of Eq. 1, (a) for
    three Y at β near 150 and (b) for at most three β at the largest Y.

    Raises FigureSkipped if the study stores no tip histories.
    """
    if not study.stores_tip:
        stored = study.settings.get("study.store", "fit")
        raise FigureSkipped(f"the study stores no tip histories (store = \"{stored}\").")
    points = fitted_points(study)
    figure = new_figure(2.8, conditions(study))
    modulus_axes, damping_axes = figure.subplots(1, 2, sharey=True)
    rows = rows_of_varied_modulus(points)
    labels, title = labels_and_title(
        points.youngs_modulus[rows], points.damping[rows], describe_modulus, describe_damping
    )
    draw_histories(modulus_axes, study, points, rows, labels)
    modulus_axes.set_title(title)
    rows = rows_of_varied_damping(points)
    labels, title = labels_and_title(
        points.damping[rows], points.youngs_modulus[rows], describe_damping, describe_modulus
    )
    draw_histories(damping_axes, study, points, rows, labels)
    damping_axes.set_title(title)
    modulus_axes.set_ylabel("Tip deflection / initial deflection (–)")
    leave_room_above(modulus_axes, 0.16)
    mark(modulus_axes, "a")
    mark(damping_axes, "b")
    return figure
