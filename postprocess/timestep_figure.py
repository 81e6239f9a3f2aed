# SPDX-License-Identifier: BSD-3-Clause
"""The figure of a time-step study: the largest stable steps, and the errors of b1 and b2."""
from __future__ import annotations

import matplotlib
import numpy as np

from culm.archive import Study
from figure_style import mark, new_figure, styled
from palette import BLACK, BLUE, COLOUR_MAP, VERMILLION, number
from study_points import YOUNGS_MODULUS_KEY, conditions
from timestep_results import Errors, Limits, errors_of, fitted_law, limits_of

MOST_MODULI_IN_HEADING = 4


def drawn_damping(damping: np.ndarray) -> np.ndarray:
    """Puts undamped stems at the left end of the logarithmic axis."""
    positive = damping[damping > 0.0]
    smallest = positive.min() if positive.size else 1.0
    return np.where(damping > 0.0, damping, 0.5 * smallest)


def damping_label(damping: np.ndarray) -> str:
    label = "Bond damping β (–)"
    return label if damping.min() > 0.0 else label + ", left end: 0"


def draw_limits(axes, study: Study, limits: Limits):
    """Δt/τ against β: one curve for every Y."""
    x = drawn_damping(limits.damping)
    order = np.argsort(x)
    axes.loglog(
        x, limits.bisected / limits.bond_time, "o", color=BLUE, markersize=4, label="bisected runs"
    )
    axes.plot(
        x[order],
        (limits.linearised / limits.bond_time)[order],
        color=BLACK,
        linewidth=0.8,
        label="linearised chain",
    )
    axes.plot(
        x[order],
        (limits.rule / limits.bond_time)[order],
        color=VERMILLION,
        linestyle=(0, (4, 2)),
        label="authors' rule",
    )
    law = fitted_law(study)
    if law is not None:
        axes.text(
            0.04,
            0.04,
            rf"$(\tau/\Delta t)^2$ = {number(law[0])} + {number(law[1])} $\beta\,\tau/\Delta t$",
            transform=axes.transAxes,
            fontsize=6,
        )
    axes.set_xlabel(damping_label(limits.damping))
    axes.set_ylabel(r"Limit $\Delta t/\tau$ with $\tau=\sqrt{m/k_n}$ (–)")
    axes.legend(loc="upper right")


def draw_ratios(axes, limits: Limits):
    """Both predictions over the bisected limit, on a linear scale that shows small differences."""
    x = drawn_damping(limits.damping)
    rule, linearised = limits.rule / limits.bisected, limits.linearised / limits.bisected
    axes.semilogx(x, rule, "s", color=VERMILLION, markersize=3.5, label="authors' rule")
    axes.semilogx(x, linearised, "o", color=BLACK, markersize=2.5, label="linearised chain")
    axes.axhline(1.0, color=BLACK, linewidth=0.6)
    axes.legend(loc="center right")
    axes.set_xlabel(damping_label(limits.damping))
    axes.set_ylabel("Prediction / bisected limit (–)")


def draw_errors(axes, errors: Errors, damping: np.ndarray, quantity: str, symbol: str):
    """|error| against Δt over the limit."""
    measured = np.abs(getattr(errors, quantity))
    levels = np.unique(damping)
    colours = matplotlib.colormaps[COLOUR_MAP](np.linspace(0.0, 0.9, levels.size))
    for level, colour in zip(levels, colours):
        for row in np.flatnonzero(damping == level):
            is_first = row == np.flatnonzero(damping == level)[0]
            axes.loglog(
                errors.fractions[row],
                measured[row],
                "o",
                color=colour,
                markersize=3,
                label=f"β = {number(level)}" if is_first else None,
            )
    least = 0.99 * errors.fractions.min()
    ticks = [tick for tick in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0) if tick >= least]
    axes.set_xticks(ticks, [number(tick) for tick in ticks])
    axes.set_xlabel(r"$\Delta t$ / linearised limit (–)")
    axes.set_ylabel(f"|relative error| of {symbol}")


@styled
def timestep_figure(study: Study):
    """(a) the largest stable step over τ = √(m/k_n) against β by bisection, by the linearised chain
    and by the authors' rule; (b) both predictions over the bisected limit; (c) and (d) errors of b1
    and b2 against the step, if steps were compared.
    """
    limits = limits_of(study)
    errors = errors_of(study, limits)
    moduli = np.unique(study.parameter(YOUNGS_MODULUS_KEY)[study.is_completed])
    heading = conditions(study)
    if moduli.size <= MOST_MODULI_IN_HEADING:
        heading += f"; Y = {', '.join(number(y) for y in moduli)} GPa"
    figure = new_figure(2.8 if errors is None else 5.2, heading)
    all_axes = figure.subplots(1 if errors is None else 2, 2, squeeze=False)
    draw_limits(all_axes[0, 0], study, limits)
    draw_ratios(all_axes[0, 1], limits)
    if errors is not None:
        draw_errors(all_axes[1, 0], errors, limits.damping, "decay", "$b_1$ per cycle")
        draw_errors(all_axes[1, 1], errors, limits.damping, "frequency", "$b_2$")
        all_axes[1, 1].legend(loc="upper left", ncols=2)
    for letter, axes in zip("abcd", all_axes.flat):
        mark(axes, letter)
    return figure
