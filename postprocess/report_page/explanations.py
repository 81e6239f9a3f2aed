# SPDX-License-Identifier: BSD-3-Clause
"""The explanations of one stem or of a laboratory, and their probability."""
from __future__ import annotations

from palette import BLUE, VERMILLION
from report_page.drawing import axis, layout, level
from report_page.markup import Plot, Section, folded, table


def _name(effects: list[str]) -> str:
    return " with ".join(effects) or "published chain"


def add_explanations(section: Section, content: dict):
    """Of a diagnosis.json or laboratory.json."""
    section.heading("Explanations and their probability")
    explanations = content["explanations"]
    names = [_name(entry["effects"]) for entry in explanations]
    trace = {"type": "bar", "orientation": "h", "name": "probability", "y": names,
             "x": [entry["probability"] for entry in explanations], "hoverinfo": "x+y",
             "marker": {"color": BLUE}}
    look = layout(axis("probability", range=[0.0, 1.0]),
                  axis(type="category", autorange="reversed"),
                  legend=False, levels=[level(0.95, VERMILLION, "dash", "x")])
    section.add_plots([Plot("explanations", "", "Probability of every set of effects.", [trace],
                            look, 120 + 30 * len(explanations))],
                      "The probability of each set of effects among all models that were fitted or "
                      "predicted. An answer needs 0.95 (dashed line). Several long bars mean that "
                      "the recordings cannot distinguish these sets.")
    if content["immaterial"]:
        section.add(table(["detectable, immaterial", "rms that it explains, / noise"],
                          [[entry["effect"], entry["over_noise"]]
                           for entry in content["immaterial"]]))
    rows = [[_name(entry["effects"]), entry["log_evidence"], entry["probability"],
             entry.get("failure", "")] for entry in content["models"]]
    section.add(folded("All models that were fitted", table(
        ["effects", "log evidence over the best", "probability", "failure"], rows)))
