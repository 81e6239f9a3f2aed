# SPDX-License-Identifier: BSD-3-Clause
"""What every study's section holds besides its figures: completion, failures, cost, provenance."""
from __future__ import annotations

from collections import Counter

import numpy as np

from culm_archive import Study, StudyError
from palette import ORANGE
from report_page.drawing import axis, bars, histogram_of, layout
from report_page.markup import Plot, Section, escaped, facts, folded, table

# Result columns that say what a point cost, the same whichever machine computed it.
COST_COLUMNS = (("rhs_evaluations", "evaluations of the right-hand side"),
                ("steps", "steps of the integrator"))


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
    """The failed points with their reasons, nothing if there is none."""
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
    """Wall time of the run and what each point cost."""
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
                              layout(axis(label), axis("points"), legend=False, bargap=0), 230))
    if plots:
        section.add_plots(plots, "What a point cost, whichever machine computed it.")
    section.add(facts(rows))


def add_provenance(section: Section, study: Study):
    """How the study came about, with its configuration as it was written."""
    entries = study.provenance
    config = entries.pop("config", "")
    section.heading("Provenance")
    section.add(facts([[name.replace("_", " "), text] for name, text in entries.items()]))
    if config:
        section.add(folded("The study file", f"<pre>{escaped(config)}</pre>"))
    section.add(folded("Every setting after defaults",
                       facts(list(study.settings.items()))))
