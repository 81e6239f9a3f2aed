# SPDX-License-Identifier: BSD-3-Clause
"""The regressions of a study compared with those of Schramm et al. (2019): laws and residuals."""
from __future__ import annotations

import textwrap
from dataclasses import dataclass

import numpy as np

from culm.archive import Study
from figure_style import colour_bar, leave_room_above, mark, new_figure, styled
from palette import BLACK, BLUE, COLOUR_MAP, VERMILLION, number
from histogram import histogram_of
from study_laws import Law, StudyLaw, published_laws, published_residual_counts, study_law
from study_points import StudyPoints, conditions, fitted_points

@dataclass(frozen=True)
class Panel:
    """One response against its predictor."""

    response_key: str  # in summary.json
    response: np.ndarray  # (M)
    predictor: np.ndarray  # (M)
    drawn_sign: float  # the axis shows drawn_sign · predictor
    colour: np.ndarray  # (M), the other factor
    symbol: str
    predictor_symbol: str
    response_label: str
    predictor_label: str
    colour_label: str
    published: Law | None  # only of the published stem
    published_name: str
    published_equation: str


def panels_of(study: Study, points: StudyPoints) -> tuple[Panel, Panel]:
    of_modulus, of_damping = published_laws(study)
    youngs_modulus = Panel(
        response_key="sqrt_youngs_modulus",
        response=np.sqrt(points.youngs_modulus),
        predictor=points.frequency,
        drawn_sign=1.0,
        colour=points.damping,
        symbol=r"$\sqrt{Y}$",
        predictor_symbol="$b_2$",
        response_label=r"$\sqrt{Y}$ ($10^4\,\sqrt{\mathrm{Pa}}$)",
        predictor_label="Frequency $b_2$ (Hz)",
        colour_label="Bond damping β (–)",
        published=of_modulus,
        published_name="Eq. 12",
        published_equation=r"$\sqrt{Y}$ = 574.3 $b_2$ + 91.4",
    )
    damping = Panel(
        response_key="bond_damping",
        response=points.damping,
        predictor=points.decay_per_cycle,
        drawn_sign=-1.0,
        colour=1e-9 * points.youngs_modulus,
        symbol="β",
        predictor_symbol="$b_1$",
        response_label="Bond damping β (–)",
        predictor_label="Decay per cycle $-b_1$ (–)",
        colour_label="Bond Young's modulus $Y$ (GPa)",
        published=of_damping,
        published_name="Eq. 13",
        published_equation="β = \N{MINUS SIGN}261.4 $b_1$ + 2.5",
    )
    return youngs_modulus, damping


def equation(panel: Panel, law: Law) -> str:
    sign = "+" if law.intercept >= 0.0 else "\N{MINUS SIGN}"
    slope = number(law.slope)
    return f"{panel.symbol} = {slope} {panel.predictor_symbol} {sign} {number(abs(law.intercept))}"


def colours(panel: Panel) -> dict:
    """Colour arguments of a scatter plot: coloured by the other factor if that factor varies."""
    if np.ptp(panel.colour) == 0.0:
        return {"color": BLUE}
    return {"c": panel.colour, "cmap": COLOUR_MAP}


def draw_laws(axes, panel: Panel, found: StudyLaw | str):
    """The fitted law, and the published one if there is one, over the range of the points."""
    drawn = panel.drawn_sign * panel.predictor
    ends = np.array([drawn.min(), drawn.max()])
    ends += np.array([-0.04, 0.04]) * (np.ptp(ends) or abs(ends[0]))
    predictor = panel.drawn_sign * ends
    if isinstance(found, StudyLaw):
        label = (
            f"this study: {equation(panel, found.law)}\n"
            f"adjusted $R^2$ = {found.adjusted_r_squared:.5f}, $n$ = {drawn.size}"
        )
        axes.plot(ends, found.law(predictor), color=BLACK, label=label, zorder=2)
    if panel.published is None:
        return
    axes.plot(
        ends,
        panel.published(predictor),
        color=VERMILLION,
        linestyle=(0, (4, 2)),
        label=f"Schramm et al. (2019), {panel.published_name}:\n{panel.published_equation}",
        zorder=4,
    )


def no_regression(axes, reason: str):
    """Writes the reason into an empty panel."""
    text = textwrap.fill(f"No regression: {reason}", 48)
    axes.text(0.5, 0.5, text, parse_math=False, transform=axes.transAxes, ha="center", va="center",
              fontsize=7)
    axes.set_yticks([])


def draw_residuals(axes, panel: Panel, law: Law):
    """Residuals of the fitted law, which are not visible at the scale of the panel above."""
    residuals = law.residuals_percent(panel.predictor, panel.response)
    drawn = panel.drawn_sign * panel.predictor
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    axes.scatter(drawn, residuals, s=9, linewidths=0, zorder=3, **colours(panel))
    axes.set_ylabel("Residual (%)")
    largest = 1.15 * max(np.abs(residuals).max(), np.finfo(float).tiny)
    axes.set_ylim(-largest, largest)


def draw_regression(figure, upper, lower, panel: Panel, found: StudyLaw | str):
    """One column of the regression figure: the laws in the upper panel, the residuals below."""
    drawn = panel.drawn_sign * panel.predictor
    shown = upper.scatter(drawn, panel.response, s=14, linewidths=0, zorder=3, **colours(panel))
    if np.ptp(panel.colour) > 0.0:
        colour_bar(figure, shown, [upper, lower], panel.colour_label, panel.colour)
    draw_laws(upper, panel, found)
    upper.set_ylabel(panel.response_label)
    leave_room_above(upper, 0.34)
    if upper.lines:
        upper.legend(loc="upper left")
    lower.set_xlabel(panel.predictor_label)
    if isinstance(found, str):
        no_regression(lower, found)
        return
    draw_residuals(lower, panel, found.law)


@styled
def regression_figure(study: Study):
    """(a) √Y against b2 and (b) β against −b1 per cycle, points coloured by the other factor, with
    the laws fitted to the study and Eqs. 12 and 13 of Schramm et al. (2019); below them the
    residuals of the fitted laws, in per cent of the largest observed value."""
    points = fitted_points(study)
    figure = new_figure(3.8, conditions(study))
    all_axes = figure.subplots(2, 2, sharex="col", height_ratios=(3.2, 1.0))
    for column, panel in enumerate(panels_of(study, points)):
        upper, lower = all_axes[:, column]
        draw_regression(figure, upper, lower, panel, study_law(study, panel.response_key))
        mark(upper, "ab"[column])
    all_axes[0, 0].yaxis.set_major_formatter(lambda value, _: number(1e-4 * value))
    return figure


def draw_published_residuals(axes, panel: Panel, edges: np.ndarray):
    """Draws the residuals of the published law on the same points, or a remark if that law is for
    other stems or the bins are too narrow for it."""
    name = f"Schramm et al. (2019), {panel.published_name}"
    found = published_residual_counts(panel.published, panel.predictor, panel.response, edges)
    if found is None:
        residuals = panel.published.residuals_percent(panel.predictor, panel.response)
        mean = number(residuals.mean(), 3)
        axes.plot([], [], " ", label=f"{name}:\n{mean} % on average, not shown")
        return
    counts, bins = found
    axes.stairs(counts, bins, color=VERMILLION, linewidth=1.2, label=name)


@styled
def residual_figure(study: Study):
    """Residuals in per cent of the largest observed value (the paper's Fig. 8) of (a) √Y and (b) β,
    for the laws fitted to the study and, of the published stem, for the published laws."""
    points = fitted_points(study)
    figure = new_figure(2.7, conditions(study))
    all_axes = figure.subplots(1, 2)
    for letter, axes, panel in zip("ab", all_axes, panels_of(study, points)):
        found = study_law(study, panel.response_key)
        mark(axes, letter)
        axes.set_xlabel(f"Residual of {panel.symbol} (% of the largest value)")
        axes.set_ylabel("Number of points")
        if isinstance(found, str):
            no_regression(axes, found)
            axes.set_xticks([])
            continue
        counts, edges = histogram_of(found.law.residuals_percent(panel.predictor, panel.response))
        axes.stairs(
            counts,
            edges,
            fill=True,
            color=BLUE,
            alpha=0.6,
            label=f"this study: {equation(panel, found.law)}",
        )
        if panel.published is not None:
            draw_published_residuals(axes, panel, edges)
        axes.axvline(0.0, ymax=0.7, color=BLACK, linewidth=0.6, linestyle=":")
        axes.legend(loc="upper left")
        leave_room_above(axes, 0.3)
        axes.yaxis.get_major_locator().set_params(integer=True)
    return figure
