# SPDX-License-Identifier: BSD-3-Clause
"""A time-step study: the largest stable explicit steps, and the errors of b1 and b2 below them."""
from __future__ import annotations

import numpy as np

from culm.archive import Study, StudyError
from palette import BLACK, BLUE, VERMILLION, number
from report_page.drawing import axis, dots, heat_map, layout, level, log_axis
from report_page.markup import Plot, Section, shown, table
from study_points import DAMPING_KEY, YOUNGS_MODULUS_KEY
from timestep_results import Errors, Limits, errors_of, fitted_law, limits_of


def add_timestep(section: Section, study: Study):
    """Verdict, map of the limit, its predictions, and the errors below it."""
    try:
        limits = limits_of(study)
    except StudyError as error:
        section.verdict.append(str(error))
        return
    section.verdict += _sentences(study, limits)
    section.heading("The largest stable step")
    moduli = study.parameter(YOUNGS_MODULUS_KEY)[study.is_completed]
    texts = [f"Y = {number(y)} GPa, β = {number(b)}: Δt = {number(dt, 3)} s"
             for y, b, dt in zip(moduli, limits.damping, limits.bisected)]
    plots = [_map_plot(moduli, limits), _over_bond_time(limits, texts), _ratios(limits, texts)]
    section.add_plots(plots, "The largest stable step Δt of velocity Verlet, by bisection of real runs: as a "
                             "map, over the time constant τ of a bond, and next to its predictions. A good "
                             "prediction lies on the line at 1; above it a prediction is unsafe.",
                      _limits_table(study, moduli, limits))
    errors = errors_of(study, limits)
    if errors is not None:
        section.heading("Errors of b1 and b2 for steps below the limit")
        section.add_plots([_error_plot(errors, "decay", "b1 per cycle"),
                           _error_plot(errors, "frequency", "b2")],
                          "Relative error against the value extrapolated to step zero, over the step in "
                          "units of its limit.")


def _sentences(study: Study, limits: Limits) -> list[str]:
    low, high = limits.bisected.min(), limits.bisected.max()
    ratio, rule = limits.bisected / limits.linearised, limits.rule / limits.bisected
    found = [f"The largest stable explicit step lies between {shown(float(low), 3)} s and "
             f"{shown(float(high), 3)} s over this design.",
             f"The linearised chain predicts it: bisected over linearised {number(ratio.min())} to "
             f"{number(ratio.max())}. The authors' rule gives {number(100 * rule.min(), 3)} to "
             f"{number(100 * rule.max(), 3)} % of it" +
             (", on the safe side." if rule.max() <= 1.0 else "; it is too large where it exceeds 100 %.")]
    law = fitted_law(study)
    if law:
        found.append(f"With τ = √(m/k_n): (τ/Δt)² = {number(law[0])} + {number(law[1])} β τ/Δt.")
    return found


def _map_plot(moduli, limits: Limits) -> Plot:
    """log10 of the limit over (Y, β)."""
    levels_y, column = np.unique(moduli, return_inverse=True)
    levels_b, row = np.unique(limits.damping, return_inverse=True)
    cells = np.full((levels_b.size, levels_y.size), np.nan)
    cells[row, column] = np.log10(limits.bisected)
    trace = heat_map([f"{number(y)}" for y in levels_y], [f"{number(b)}" for b in levels_b], cells,
                     "log₁₀ Δt/s")
    return Plot("limit-map", "Largest stable step", "Map of the largest stable step over Young's "
                "modulus and damping.", [trace],
                layout(axis("bond Young's modulus Y, GPa", type="category"),
                       axis("bond damping β", type="category"), legend=False))


def _shown_damping(damping: np.ndarray) -> np.ndarray:
    """Puts undamped stems at half of the smallest positive damping, for a logarithmic axis."""
    positive = damping[damping > 0.0]
    return np.where(damping > 0.0, damping, 0.5 * (positive.min() if positive.size else 1.0))


def _damping_label(damping: np.ndarray) -> str:
    return "bond damping β" + ("" if damping.min() > 0.0 else " (left end: 0)")


def _over_bond_time(limits: Limits, texts: list[str]) -> Plot:
    x, order = _shown_damping(limits.damping), np.argsort(limits.damping, kind="stable")
    traces = [dots(x, limits.bisected / limits.bond_time, "bisected", BLUE, 7, text=texts,
                   hoverinfo="text")]
    for values, name, colour, symbol in (
            (limits.linearised, "linearised chain", BLACK, "line-ew-open"),
            (limits.rule, "authors' rule", VERMILLION, "diamond-open")):
        traces.append(dots(x[order], (values / limits.bond_time)[order], name, colour, 9, symbol))
    heights = np.concatenate([limits.bisected, limits.linearised, limits.rule]) / np.tile(
        limits.bond_time, 3)
    return Plot("limit-curve", "Over the time constant of a bond", "Largest stable step over the square root "
                "of mass over stiffness, against the damping.", traces,
                layout(log_axis(_damping_label(limits.damping), x),
                       log_axis("Δt/τ, τ = √(m/k_n)", heights)))


def _ratios(limits: Limits, texts: list[str]) -> Plot:
    x = _shown_damping(limits.damping)
    traces = [dots(x, limits.linearised / limits.bisected, "linearised chain", BLACK, 9, "line-ew-open",
                   text=texts, hoverinfo="y+text"),
              dots(x, limits.rule / limits.bisected, "authors' rule", VERMILLION, 7,
                   "diamond-open", text=texts, hoverinfo="y+text")]
    return Plot("limit-ratio", "Predictions over the bisected limit", "Both predictions over the "
                "bisected limit, against the damping.", traces,
                layout(log_axis(_damping_label(limits.damping), x), axis("predicted / bisected"),
                       levels=[level(1.0)]))


def _error_plot(errors: Errors, quantity: str, label: str) -> Plot:
    measured = np.abs(getattr(errors, quantity))
    known = np.isfinite(measured) & (measured > 0.0)
    traces = [dots(errors.fractions[known], measured[known], "computed", BLUE, 6)]
    return Plot(f"error-{quantity}", f"Error of {label}", f"Relative error of {label} against the "
                "step over its limit.", traces,
                layout(log_axis("Δt / linearised limit", errors.fractions[known]),
                       log_axis(f"|relative error| of {label}", measured[known]), legend=False))


def _limits_table(study: Study, moduli, limits: Limits) -> str:
    rows = [[float(y), float(b), float(found), float(linear), float(rule), float(rule / found)]
            for y, b, found, linear, rule in zip(moduli, limits.damping, limits.bisected,
                                                 limits.linearised, limits.rule)]
    return table(["Y, GPa", "β", "bisected, s", "linearised, s", "authors' rule, s",
                  "rule / bisected"], rows, f"{DAMPING_KEY}, {YOUNGS_MODULUS_KEY}: every "
                 f"completed point of {study.points}.")
