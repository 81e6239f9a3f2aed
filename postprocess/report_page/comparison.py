# SPDX-License-Identifier: BSD-3-Clause
"""Model against measurement: the verdict, the ladder, where the models fail, the moving stem."""
from __future__ import annotations

from culm.checked_hdf5 import StudyError
from command_results import Comparison, name_of, numbers
from palette import BLUE
from report_page.drawing import axis, dots, layout, level, log_axis
from report_page.markup import Plot, Section, facts, folded, provenance_rows, shown, table
from report_page.measured import (AMPLITUDE_CAPTION, FIRST, LAST, PARAMETER_COLUMNS, WHERE_CAPTION,
                                  WITH_FREE_INPUTS, add_motion, amplitude_plots, amplitude_table,
                                  colour_limit, contradictions, legend_of, map_array, map_plot,
                                  parameter_rows, read_motion, where_plots, where_table)

MOST_MAPS = 3


def comparison_section(comparison: Comparison, key: str, place: str) -> Section:
    """The section of a folder of `culm compare -o`."""
    section = Section(key, f"Comparison of {comparison.measurement} ({place})")
    _add_verdict(section, comparison)
    section.heading("Residual by model")
    _add_ladder(section, comparison)
    section.heading("Where the models fail")
    _add_maps(section, comparison)
    wheres = _first_and_last(comparison)
    section.add_plots(where_plots(wheres), WHERE_CAPTION,
                      where_table(wheres[-1][1]), legend_of(wheres))
    plots = amplitude_plots(wheres)
    if plots:
        section.heading("Against the amplitude")
        section.add_plots(plots, AMPLITUDE_CAPTION, amplitude_table(wheres[-1][1]),
                          legend_of(wheres))
    _add_motion(section, comparison)
    _add_parameters(section, comparison)
    _add_provenance(section, comparison)
    return section


def best_rung(comparison: Comparison) -> dict:
    """The last model that improves on its predecessor, or the baseline if none does."""
    return comparison.content["ladder"][comparison.content["best"]]


def _add_verdict(section: Section, comparison: Comparison):
    base, best = comparison.rungs[0], best_rung(comparison)
    section.tone = "good" if best["verdict"]["finding"] == "adequate" else "doubt"
    section.verdict.append(comparison.content["headline"])
    section.verdict.append(f"The published chain: {base['sentences'][0]}")
    if best is base:
        section.verdict += base["sentences"][1:]
    else:
        section.verdict.append(f"With {' and '.join(best['model'][1:])}: {best['sentences'][0]}")
        section.verdict += [*best["sentences"][1:], best["step"]]
    section.verdict += [rung["step"] for rung in comparison.rungs[1:] if not rung["gain"]]


def _add_ladder(section: Section, comparison: Comparison):
    rungs = comparison.rungs
    labels = [" + ".join(rung["model"]) for rung in rungs]
    shares = [rung["rmse_over_noise"] for rung in rungs]
    plot = Plot("ladder", "", "Residual over noise of every model on the ladder.",
                [dots(numbers(shares), labels, "residual", BLUE, 10, "circle")],
                layout(log_axis("residual / noise (1: only noise)", [1.0, *shares]),
                       axis(type="category", range=[len(rungs) - 0.5, -0.5]), legend=False,
                       levels=[level(1.0, along="x")]), 150 + 42 * len(rungs))
    rows = [[name_of(rung), rung["rmse_mm"], rung["rmse_over_noise"], rung["reduced_chi2"],
             rung["log_evidence"], rung.get("log_evidence_gain"), contradictions(rung),
             rung["verdict"]["finding"],
             {True: "improves", False: "no improvement"}.get(rung.get("gain"), "")] for rung in rungs]
    section.add_plots([plot], "The rms of the residuals over the noise for each model, the published "
                              "chain first. At the grey line at 1 the residuals are as large as the noise; "
                              "further right a model is worse.")
    section.add(table(["model", "rms, mm", "/ noise", "reduced chi²*", "log evidence*", "gain*",
                       "contradicted inputs", "verdict*", ""], rows, WITH_FREE_INPUTS))


def _first_and_last(comparison: Comparison) -> list:
    rungs, best = comparison.rungs, best_rung(comparison)
    last = best if best is not rungs[0] else rungs[-1]
    chosen = [(rungs[0], FIRST), (last, LAST)] if last is not rungs[0] else [(last, LAST)]
    return [(name_of(rung), rung["where"], colour) for rung, colour in chosen]


def _add_maps(section: Section, comparison: Comparison):
    rungs = comparison.rungs
    rungs = rungs if len(rungs) <= MOST_MAPS else [*rungs[:MOST_MAPS - 1], rungs[-1]]
    maps = [rung["where"]["residual_map"] for rung in rungs]
    if len(maps[0]["height_mm"]) < 2:
        return
    values = [map_array(entry) for entry in maps]
    limit = colour_limit(*values)
    plots = [map_plot(f"map-{k}", f"{name_of(rung)}: {shown(rung['rmse_mm'], 3)} mm rms",
                      entry["time_s"], entry["height_mm"], value, limit)
             for k, (rung, entry, value) in enumerate(zip(rungs, maps, values))]
    for plot in plots:
        section.add_plots([plot], "" if plot is not plots[-1] else
                          "Measured − modelled over time and height, all maps on one scale: blue "
                          "below zero, red above. A good model leaves noise, which has no pattern; "
                          "stripes in time are motion that the model lacks.")


def _add_motion(section: Section, comparison: Comparison):
    section.heading("The motion")
    try:
        motion = read_motion(comparison.file.parent / "deflections.csv")
    except StudyError as refusal:
        section.note(str(refusal))
        return
    if motion is None:
        section.note("`culm compare -o DIR` writes deflections.csv, from which the motion is drawn; "
                     "this folder lacks it.")
        return
    add_motion(section, "all", motion, name_of(comparison.rungs[0]),
               name_of(best_rung(comparison)), comparison.noise_mm)


def _add_parameters(section: Section, comparison: Comparison):
    section.heading("Parameters")
    for rung in comparison.rungs:
        content = table(PARAMETER_COLUMNS, parameter_rows(rung["parameters"]))
        content += table(["test", "p", "p, adjusted for their number"],
                         [[test["name"], test["p_value"], test["adjusted_p_value"]]
                          for test in rung["verdict"]["tests"]])
        if rung is best_rung(comparison):
            section.add(table(PARAMETER_COLUMNS, parameter_rows(rung["parameters"]), name_of(rung)))
        section.add(folded(f"{name_of(rung)}: parameters and tests", content))


def _add_provenance(section: Section, comparison: Comparison):
    content = comparison.content
    section.heading("Provenance and cost")
    rows = [["recording", content["folder"]],
            ["frames, heights", f"{content['frames']}, {content['heights']}"],
            ["noise", f"{shown(content.get('noise_mm'), 3)} mm ({content.get('noise_source', '–')})"],
            ["batches of lanes", sum(rung["runs"] for rung in comparison.rungs)]]
    rows += [[name.replace("_", " "), "–" if value in (None, "") else value]
             for name, value in content["options"].items()]
    rows += provenance_rows(content)
    section.add(facts(rows))
    failed = [rung for rung in content["ladder"] if "failure" in rung]
    if failed:
        section.heading("Models that could not be fitted")
        section.add(table(["model", "why"], [[name_of(r), r["failure"]] for r in failed]))
    for remark in content["remarks"]:
        section.note(remark)
