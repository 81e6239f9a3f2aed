# SPDX-License-Identifier: BSD-3-Clause
"""A population of stems: histograms of what was drawn and of what came out, and which factor the
scatter comes from."""
from __future__ import annotations

import numpy as np

from culm_archive import Study
from palette import BLUE, ORANGE, VERMILLION
from report_page.drawing import axis, bars, histogram_of, layout, level
from report_page.markup import Plot, Section, plain, shown, table
from report_page.picker import factor_name

FEWEST_LEVELS = 15  # of a factor that was drawn, not chosen
ANSWERS = {"frequency": "b2", "decay_per_cycle": "b1 per cycle"}


def add_population(section: Section, study: Study):
    """Histograms of what was drawn and of what came out, for studies with many levels."""
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
        title = plain(label if unit == "1" or "per cycle" in label else f"{label}, {unit}")
        counts, edges = histogram_of(values)
        known = values[np.isfinite(values)]
        low, median, high = np.quantile(known, [0.05, 0.5, 0.95])
        rows.append([label, unit, float(known.mean()), float(known.std(ddof=1)), float(low),
                     float(median), float(high)])
        plots.append(Plot(f"population-{len(plots)}", "", f"Histogram of {label}.",
                          [bars(counts, edges)],
                          layout(axis(title), axis("stems"), legend=False, bargap=0,
                                 shapes=[level(float(median), VERMILLION, "dash", "x")]), 240))
    if not plots:
        return
    section.heading("The population")
    section.add_plots(plots, f"Of the {int(done.sum())} completed stems; dashed: the median.",
                      table(["quantity", "unit", "mean", "sd", "5 %", "median", "95 %"], rows))


def add_sensitivity(section: Section, study: Study):
    """Sobol indices of b1 and b2 (docs/replicates.md), where the summary has them."""
    found = study.summary.get("sensitivity")
    if not isinstance(found, dict) or not any(name in found for name in ANSWERS):
        return
    plots, rows = [], []
    for name, label in ANSWERS.items():
        entry = found.get(name)
        if not isinstance(entry, dict) or "indices" not in entry:
            continue
        groups = [factor_name(index["group"]) for index in entry["indices"]]
        traces = []
        for member, title, colour in (("first_order", "alone", BLUE),
                                      ("total", "with interactions", ORANGE)):
            values = [100.0 * index[member]["value"] for index in entry["indices"]]
            ends = [index[member]["interval"] for index in entry["indices"]]
            trace = {"type": "bar", "orientation": "h", "name": title, "x": values,
                     "y": [plain(group) for group in groups], "marker": {"color": colour},
                     "hoverinfo": "x+y",
                     "error_x": {"type": "data", "symmetric": False, "thickness": 1,
                                 "array": [100.0 * high - v for (_, high), v in zip(ends, values)],
                                 "arrayminus": [v - 100.0 * low
                                                for (low, _), v in zip(ends, values)]}}
            traces.append(trace)
            rows += [[label, group, title, f"{shown(value, 3)} %",
                      f"{shown(100.0 * low, 3)} … {shown(100.0 * high, 3)} %"]
                     for group, value, (low, high) in zip(groups, values, ends)]
        plots.append(Plot(f"sensitivity-{name.replace('_', '-')}", f"Where the scatter of {label} "
                          "comes from", f"Share of the variance of {label} by factor.", traces,
                          layout(axis("share of the variance, %", rangemode="tozero"),
                                 axis(type="category", autorange="reversed"),
                                 24 + 7 * max(map(len, groups)), barmode="group"),
                          130 + 44 * len(groups)))
    if plots:
        section.heading("Which factor makes the scatter")
        section.add_plots(plots, f"Sobol indices by {found.get('method', 'the study')}; bars: 95 %.",
                          table(["of", "factor", "", "share", "95 %"], rows))
