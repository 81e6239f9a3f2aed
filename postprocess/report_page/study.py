# SPDX-License-Identifier: BSD-3-Clause
"""A study of vibrations: its laws, their validity, its points with their histories, its cost."""
from __future__ import annotations

from collections import Counter

import numpy as np

from culm.archive import Study, StudyError
from design_map import decay_per_damping, frequency_deviation_percent, grid_of, map_obstacle
from histogram import histogram_of
from palette import BLACK, BLUE, ORANGE, VERMILLION, number
from report_page.drawing import (SEQUENTIAL, axis, bars, chosen_rows, dots, heat_map,
                                 layout, level, line, outline)
from report_page.markup import Plot, Section, escaped, facts, folded, shown, table
from report_page.picker import add_picker, factor_name
from report_page.timestep import add_timestep
from study_laws import Law, StudyLaw, published_laws, published_residual_counts, study_law
from study_points import StudyPoints, conditions, fitted_points
from timestep_results import is_timestep_study

# Result columns that state the cost of a point, independently of the machine that computed it.
COST_COLUMNS = (("rhs_evaluations", "evaluations of the right-hand side"),
                ("steps", "steps of the integrator"),
                ("jacobian_evaluations", "evaluations of the Jacobian"),
                ("factorisations", "factorisations of the Newton matrix"),
                ("newton_iterations", "iterations of Newton's method"),
                ("error_test_failures", "steps rejected by the error test"),
                ("convergence_failures", "steps given up by Newton's method"))
FEWEST_LEVELS = 15  # of a factor that was drawn, not chosen
ANSWERS = {"frequency": "b2", "decay_per_cycle": "b1 per cycle"}


def study_section(study: Study, key: str, place: str) -> Section:
    """The section of a result folder of `culm run`."""
    section = Section(key, title_of(study, place))
    section.verdict.append(completion_sentence(study))
    section.tone = "good" if study.is_completed.all() else "doubt"
    if stem := _summary(study).get("stem"):
        section.verdict.append(f"Stem of point 0: {stem}.")
    if is_timestep_study(study):
        add_timestep(section, study)
    else:
        add_vibrations(section, study)
    add_failures(section, study)
    add_cost(section, study)
    add_provenance(section, study)
    return section


def add_vibrations(section: Section, study: Study):
    try:
        points = fitted_points(study)
    except StudyError as error:
        section.verdict.append(str(error))
        return
    responses = _responses(study, points)
    section.verdict += [_law_sentence(study, response) for response in responses]
    laws = [(response, study_law(study, response.key)) for response in responses]
    laws = [_equation(r, found.law) for r, found in laws if isinstance(found, StudyLaw)]
    if laws:
        section.verdict[0] += f" {'; '.join(laws)}."
    texts = [_point_text(points, row) for row in range(points.id.size)]
    section.heading("Calibration regressions")
    _add_regressions(section, study, points, responses, texts)
    _add_residual_histograms(section, study, responses)
    section.heading("The points")
    add_picker(section, study, points)
    _add_maps(section, study, points)
    add_population(section, study)
    add_variance_shares(section, study)


class _Response:
    """√Y on b2 (Eq. 12) or β on b1 (Eq. 13), and the published law of the published stem."""

    def __init__(self, key, symbol, predictor_symbol, values, predictor, other, published, labels):
        self.key, self.symbol, self.predictor_symbol = key, symbol, predictor_symbol
        self.values, self.predictor, self.other = values, predictor, other
        self.published: Law | None = published
        self.equation, self.label, self.predictor_label, self.other_label = labels


def _responses(study: Study, points: StudyPoints) -> tuple[_Response, _Response]:
    modulus, damping = published_laws(study)
    return (_Response("sqrt_youngs_modulus", "√Y", "b2", np.sqrt(points.youngs_modulus),
                      points.frequency, points.damping, modulus,
                      ("Eq. 12", "√Y, √Pa", "frequency b2, Hz", "bond damping β")),
            _Response("bond_damping", "β", "b1", points.damping, points.decay_per_cycle,
                      1e-9 * points.youngs_modulus, damping,
                      ("Eq. 13", "bond damping β", "decay per cycle b1", "Y, GPa")))


def _equation(response: _Response, law: Law) -> str:
    sign = "+" if law.intercept >= 0.0 else "\N{MINUS SIGN}"
    return (f"{response.symbol} = {shown(law.slope)} {response.predictor_symbol} {sign} "
            f"{shown(abs(law.intercept))}")


def _law_sentence(study: Study, response: _Response) -> str:
    found = study_law(study, response.key)
    if isinstance(found, str):
        return f"No law for {response.symbol}: {found}"
    largest = np.abs(found.law.residuals_percent(response.predictor, response.values)).max()
    sentence = (f"{_equation(response, found.law)} (adjusted R² {found.adjusted_r_squared:.5f}) "
                f"predicts {response.symbol} to within {shown(float(largest), 2)} % of its largest value")
    if response.published is None:
        return sentence + "."
    return f"{sentence}; published ({response.equation}): {_equation(response, response.published)}."


def _point_text(points: StudyPoints, row: int) -> str:
    return (f"point {points.id[row]}\nY = {number(1e-9 * points.youngs_modulus[row])} GPa, "
            f"β = {number(points.damping[row])}\nb2 = {number(points.frequency[row])} Hz, "
            f"b1 = {number(points.decay_per_cycle[row])} per cycle")


def _regression_plot(response: _Response, found: StudyLaw | str, ids, texts) -> Plot:
    """The laws in the upper panel, the residuals of the fitted law in the lower one."""
    leaves = (np.zeros(response.values.size) if isinstance(found, str)
              else found.law.residuals_percent(response.predictor, response.values))
    rows = chosen_rows(np.abs(leaves))
    cloud = dots(response.predictor[rows], response.values[rows], "points", BLUE, 7,
                 text=[texts[row] for row in rows], hoverinfo="text", showlegend=False)
    if np.ptp(response.other) > 0.0:
        cloud["marker"] |= {"color": response.other[rows], "colorscale": SEQUENTIAL,
                            "colorbar": response.other_label}
    ends = np.array([response.predictor.min(), response.predictor.max()])
    traces = [cloud]
    if isinstance(found, StudyLaw):
        traces.append(line(ends, found.law(ends), "this study", BLACK, hoverinfo="skip"))
    if response.published:
        traces.append(line(ends, response.published(ends), f"published, {response.equation}",
                           VERMILLION, "dash", hoverinfo="skip"))
    look = layout(axis(response.predictor_label),
                  axis(response.label, domain=[0.36, 1]))
    if isinstance(found, StudyLaw):
        traces.append(dots(response.predictor[rows], leaves[rows], "residual", BLUE, 4,
                           yaxis="y2", text=[f"point {point}" for point in ids[rows]],
                           hoverinfo="text+y",
                           showlegend=False))
        look["yaxis2"] = axis("residual, %", domain=[0, 0.25], zeroline=True)
    else:
        look |= {"xaxis": axis(response.predictor_label), "yaxis": axis(response.label)}
    return Plot(f"regression-{response.key}", f"{response.symbol} on {response.predictor_symbol}",
                f"{response.label} against {response.predictor_label} of every fitted point, with "
                f"the law of this study{' and the published one' if response.published else ''}; the "
                "residuals below.", traces, look, 460)


def _add_regressions(section: Section, study: Study, points: StudyPoints, responses, texts):
    found = [(response, study_law(study, response.key)) for response in responses]
    known = [pair for pair in found if isinstance(pair[1], StudyLaw)]
    plots = [_regression_plot(r, law, points.id, texts) for r, law in known or found]
    caption = (f"Every point is one simulated stem ({conditions(study)}). The lines are the laws, "
               "and the lower panels show the residuals of this study's law in per cent of the largest "
               "value. A good law leaves small residuals without a pattern; a curve in them shows that "
               "the relation is not linear.")
    if responses[0].published is None:
        caption += " The published laws are not drawn, because they are those of the paper's stem."
    most = max(len(plot.traces[0]["x"]) for plot in plots)
    if most < points.id.size:
        caption += (f" About {most} of {points.id.size} points are drawn, those with the largest "
                    "residuals among them.")
    section.add_plots(plots, caption, _laws_table(study, responses))


def _laws_table(study: Study, responses) -> str:
    rows, is_published = [], responses[0].published is not None
    for response in responses:
        entry = study.summary["regression"][response.key]
        if "reason" in entry:
            continue
        low, high = entry["interval"]["slope"]
        rows.append([response.symbol, entry["slope"], f"{shown(low, 5)} … {shown(high, 5)}",
                     entry["intercept"], f"{entry['adjusted_r2']:.5f}",
                     *([response.published.slope, response.published.intercept] if is_published else []),
                     "; ".join(f"{shown(term['coefficient'])} {term['term']}"
                               for term in entry["terms"]) or "–"])
    published = ["published slope", "published intercept"] if is_published else []
    return table(["of", "slope", "95 % interval", "intercept", "adjusted R²", *published,
                  "terms kept by F-tests"], rows)


def _add_residual_histograms(section: Section, study: Study, responses):
    plots = []
    for response in responses:
        found = study_law(study, response.key)
        if isinstance(found, str):
            continue
        counts, edges = histogram_of(
            found.law.residuals_percent(response.predictor, response.values))
        traces = [bars(counts, edges, "this study", BLUE)]
        published = response.published and published_residual_counts(
            response.published, response.predictor, response.values, edges)
        if published:
            traces.append(outline(*published, f"published, {response.equation}", VERMILLION))
        plots.append(Plot(f"residuals-{response.key}", f"Residuals of {response.symbol}",
                          f"Histogram of the residuals of {response.symbol}.", traces,
                          layout(axis(f"residual of {response.symbol}, % of the largest value"),
                                 axis("points", whole=True)), 280))
    if plots:
        section.add_plots(plots, "Number of points against their residual, as in the paper's Fig. 8. A good "
                                 "law has one narrow peak at zero. A published law is drawn only for the "
                                 "paper's stem.")


def _add_maps(section: Section, study: Study, points: StudyPoints):
    obstacle = map_obstacle(study, points)
    if obstacle:
        return
    plots = []
    for name, title, values in (
            ("frequency", "b2/√Y against its value at low β, %",
             frequency_deviation_percent(points)),
            ("decay", "−b1/β, 10⁻³ per cycle", decay_per_damping(points))):
        grid = grid_of(points, values)
        if grid is None:
            rows = chosen_rows(np.abs(values - np.median(values)))
            trace = dots(1e-9 * points.youngs_modulus[rows], points.damping[rows], title, BLUE, 7,
                         text=[number(value) for value in values[rows]], hoverinfo="x+y+text")
            trace["marker"] |= {"color": values[rows], "colorscale": SEQUENTIAL,
                                "colorbar": ""}
        else:
            moduli, dampings, cells = grid
            trace = heat_map(1e-9 * moduli, dampings, cells, "")
        plots.append(Plot(f"map-{name}", title, f"Map of {title} over Y and β.", [trace],
                          layout(axis("bond Young's modulus Y, GPa"), axis("bond damping β"),
                                 legend=False)))
    section.add_plots(plots, "Each cell or dot is one stem. Eqs. 12 and 13 hold where the colour does "
                             "not change; the scale of the colour bar shows how much it changes. The motion is one "
                             "lightly damped mode there.")


def add_population(section: Section, study: Study):
    """Histograms of random factors and of the results, for studies with many levels."""
    done = study.is_completed
    drawn = {name: values[done] for name, values in study.factors.items()
             if np.unique(values).size >= FEWEST_LEVELS}
    came_out = ANSWERS if drawn else {}
    plots, rows = [], []
    columns = [(name, factor_name(name), values)
               for name, values in drawn.items()]
    columns += [(name, label, study[name][done]) for name, label in came_out.items()]
    for name, label, values in columns:
        unit = study.unit(name)
        title = label if unit == "1" or "per cycle" in label else f"{label}, {unit}"
        counts, edges = histogram_of(values)
        known = values[np.isfinite(values)]
        low, median, high = np.quantile(known, [0.05, 0.5, 0.95])
        rows.append([label, unit, float(known.mean()), float(known.std(ddof=1)), float(low),
                     float(median), float(high)])
        plots.append(Plot(f"population-{len(plots)}", "", f"Histogram of {label}.",
                          [bars(counts, edges)],
                          layout(axis(title), axis("stems", whole=True), legend=False,
                                 levels=[level(float(median), VERMILLION, "dash", "x")]), 240))
    if not plots:
        return
    section.heading("The population")
    section.add_plots(plots, f"{int(done.sum())} completed stems: their number against each factor and "
                      "result. The dashed line is the median.",
                      table(["quantity", "unit", "mean", "sd", "5 %", "median", "95 %"], rows))


def add_variance_shares(section: Section, study: Study):
    """Shares of the variance of b1 and b2 (docs/replicates.md), where the summary has them."""
    found = study.summary.get("variance_shares")
    if not isinstance(found, dict):
        return
    plots, rows = [], []
    for name, label in ANSWERS.items():
        entry = found.get(name)
        if not isinstance(entry, dict) or entry["rest"]["value"] is None:
            continue
        groups = [factor_name(share["group"]) for share in entry["shares"]] + ["rest"]
        values = [100.0 * share["share"] for share in entry["shares"]]
        values.append(100.0 * entry["rest"]["value"])
        ends = [[100.0 * end for end in share["interval"]]
                for share in [*entry["shares"], entry["rest"]]]
        trace = {"type": "bar", "orientation": "h", "name": "share", "x": values, "y": groups,
                 "marker": {"color": BLUE}, "hoverinfo": "x+y",
                 "error_x": {"type": "data", "symmetric": False, "thickness": 1,
                             "array": [high - v for (_, high), v in zip(ends, values)],
                             "arrayminus": [v - low for (low, _), v in zip(ends, values)]}}
        rows += [[label, group, f"{shown(value, 3)} %", f"{shown(low, 3)} … {shown(high, 3)} %"]
                 for group, value, (low, high) in zip(groups, values, ends)]
        plots.append(Plot(f"variance-shares-{name.replace('_', '-')}", f"Where the scatter of "
                          f"{label} comes from", f"Share of the variance of {label} by factor.",
                          [trace], layout(axis("share of the variance, %", rangemode="tozero"),
                                          axis(type="category", autorange="reversed"),
                                          legend=False), 130 + 44 * len(groups)))
    if plots:
        section.heading("Contributions of the factors to the scatter")
        section.add_plots(plots, "Share of the variance that each factor explains by its linear and "
                          "square term; the rest is interactions, higher powers and scatter. Thin "
                          "lines are 95 % intervals. The longest bar decides the scatter.",
                          table(["of", "factor", "share", "95 %"], rows))


def title_of(study: Study, place: str) -> str:
    name = study.provenance.get("study_name", "")
    return f"Study {name}" + (f" ({place})" if place and place != name else "")


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")


def completion_sentence(study: Study) -> str:
    failed = int((study.statuses == "failed").sum())
    missing = int((study.statuses == "missing").sum())
    if not failed and not missing:
        return f"All {_counted(study.points, 'point')} were computed."
    parts = [f"{int(study.is_completed.sum())} of {_counted(study.points, 'point')} were computed"]
    if failed:
        parts.append(f"{failed} failed (listed below)")
    if missing:
        parts.append(f"{missing} are missing: `culm run --resume` computes them")
    return "; ".join(parts) + "."


def add_failures(section: Section, study: Study):
    """Lists the failed points with their reasons; adds nothing if no point failed."""
    failures = study.failures
    if not failures:
        return
    factors = study.factors
    section.heading("Failed points")
    kinds = Counter(failure.kind for failure in failures)
    section.paragraph(", ".join(f"{count} × {kind}" for kind, count in kinds.items()))
    rows = [[failure.point, *(float(values[failure.point]) for values in factors.values()),
             failure.kind, failure.reason] for failure in failures]
    section.add(table(["point", *(_with_unit(study, name) for name in factors), "kind", "reason"],
                      rows))


def _with_unit(study: Study, name: str) -> str:
    unit = study.unit(name)
    return name if unit == "1" else f"{name} ({unit})"


def _summary(study: Study) -> dict:
    try:
        return study.summary
    except StudyError:
        return {}


def add_cost(section: Section, study: Study):
    """Wall time of the run and cost of each point."""
    summary = _summary(study)
    section.heading("Cost")
    rows = [["wall time of the run that completed it, s", summary.get("wall_s")],
            ["ranks", summary.get("ranks")]]
    plots = []
    for name, label in COST_COLUMNS:
        if name not in study:
            continue
        values = study[name][study.is_completed]
        values = values[np.isfinite(values)]
        if not values.size:
            continue
        rows.append([f"{label}: in all", f"{values.sum():.0f}"])
        rows.append([f"{label}: median, largest of a point",
                     f"{np.median(values):.0f}, {values.max():.0f}"])
        if np.ptp(values) > 0.0:
            plots.append(Plot(f"cost-{name}", "", f"Histogram of the {label} of a point.",
                              [bars(*histogram_of(values), colour=ORANGE)],
                              layout(axis(label), axis("points", whole=True), legend=False), 230))
    if plots:
        section.add_plots(plots, "Number of points against the cost of a point. The cost does not "
                                 "depend on the machine. An outlier is a point that is hard to integrate.")
    section.add(facts(rows))


def add_provenance(section: Section, study: Study):
    """The provenance of the study, with its configuration as it was written."""
    entries = study.provenance
    config = entries.pop("config", "")
    section.heading("Provenance")
    section.add(facts([[name.replace("_", " "), text] for name, text in entries.items()]))
    if config:
        section.add(folded("The study file", f"<pre>{escaped(config)}</pre>"))
    section.add(folded("Every setting after defaults",
                       facts(list(study.settings.items()))))
