# SPDX-License-Identifier: BSD-3-Clause
"""Calibrated stems: Y and beta with their uncertainty, the residuals, and the population."""
from __future__ import annotations

from itertools import cycle

import numpy as np

from command_results import CalibrationError, CalibrationResults
from histogram import histogram_of
from palette import BLACK, ORANGE, SERIES, VERMILLION
from report_page.drawing import axis, bars, layout, level
from report_page.markup import (Plot, Section, facts, folded, provenance_rows, shown, table,
                                with_error)
from report_page.measured import (NAMES, PARAMETER_COLUMNS, WITH_FREE_INPUTS, add_animation, colour_limit,
                                  contradictions, legend_of, map_plot, motion_caption, motion_plots,
                                  parameter_rows)

MOST_DETAILED = 3  # stems that are drawn one by one
RELEASE = ("tip_deflection_m", "release_time_s")  # valid for one release only
QUANTITIES = (("bond_youngs_modulus_pa", "Y, GPa", 1e-9), ("bond_damping", "bond damping β", 1.0),
              ("b2_hz", "b2, Hz", 1.0), ("b1_per_cycle", "b1 per cycle", 1.0))


def calibration_section(results: CalibrationResults, key: str, place: str) -> Section:
    """The section of a folder of `culm calibrate -o`."""
    done = [stem for stem in results.stems if "failure" not in stem]
    failed = [stem for stem in results.stems if "failure" in stem]
    section = Section(key, f"Calibration ({place})")
    section.tone = "good" if done and not failed and all(
        stem["fit"]["adequate"] for stem in done) else "doubt"
    section.verdict += _sentences(results, done, failed)
    section.heading("The stems")
    section.add(_stem_table(done))
    _add_population(section, results, done)
    for number, stem in enumerate(results.stems, 1):
        if "failure" not in stem and done.index(stem) < MOST_DETAILED:
            _add_stem(section, results, number, stem)
    if len(done) > MOST_DETAILED:
        section.note(f"The first {MOST_DETAILED} of {len(done)} stems are drawn; "
                     "postprocess/calibration_figure.py --stem N draws any.")
    if failed:
        section.heading("Stems that could not be calibrated")
        section.add(table(["stem", "why"], [[s["measurement"], s["failure"]] for s in failed]))
    _add_provenance(section, results)
    return section


def _sentences(results: CalibrationResults, done: list, failed: list) -> list[str]:
    found = [stem["sentence"] for stem in done] if len(done) <= MOST_DETAILED else []
    if len(done) > MOST_DETAILED:
        missing = sum(not stem["fit"]["adequate"] for stem in done)
        found.append(f"{len(done)} stems were calibrated; the chain explains {len(done) - missing} "
                     "of them to their noise.")
    population = results.content.get("population")
    if population:
        low, high = population["bond_youngs_modulus_pa"]["central_90_percent"]
        damping = population["bond_damping"]["central_90_percent"]
        found.append(f"90 % of the stems have Y between {shown(1e-9 * low, 3)} and "
                     f"{shown(1e-9 * high, 3)} GPa and β between {shown(damping[0], 3)} and "
                     f"{shown(damping[1], 3)}.")
    if failed:
        found.append(f"{len(failed)} of {len(results.stems)} stems could not be calibrated.")
    return found


def _stem_table(stems: list) -> str:
    rows = []
    for stem in stems:
        fit, mode = stem["fit"], stem["mode"]
        rows.append([stem["measurement"],
                     with_error(stem["parameters"]["bond_youngs_modulus_pa"], 1e-9),
                     with_error(stem["parameters"]["bond_damping"]),
                     with_error(mode["b2_hz"]), with_error(mode["b1_per_cycle"]),
                     fit["rmse_mm"], fit["noise_mm"], fit["reduced_chi2"], contradictions(fit),
                     ", ".join(fit["failed_tests"]) or "none"])
    return table(["stem", "Y, GPa", "β", "b2, Hz", "b1 per cycle", "rms, mm", "noise, mm",
                  "reduced chi²*", "contradicted inputs", "failed tests*"], rows, WITH_FREE_INPUTS)


def _value(stem: dict, key: str):
    estimate = stem["parameters"].get(key) or stem["mode"].get(key)
    return np.nan if estimate["value"] is None else estimate["value"]


def _add_population(section: Section, results: CalibrationResults, stems: list):
    population = results.content.get("population")
    if not population:
        return
    plots, rows = [], []
    for key, label, factor in QUANTITIES:
        values = factor * np.array([_value(stem, key) for stem in stems], dtype=float)
        counts, edges = histogram_of(values)
        entry = population[key]
        low, high = (factor * end for end in entry["central_90_percent"])
        plots.append(Plot(f"population-{key.replace('_', '-')}", "", f"Histogram of {label}.",
                          [bars(counts, edges)],
                          layout(axis(label), axis("stems", whole=True),
                                 legend=False,
                                 levels=[level(end, VERMILLION, "dash", "x") for end in (low, high)]),
                          230))
        rows.append([label, factor * entry["mean"], factor * entry["standard_deviation"],
                     factor * entry["median"], low, high])
    section.heading("The population")
    section.add_plots(plots, "Number of stems against each result. 90 % of the stems lie between the dashed "
                             "lines. A bar far from the others is a stem to check.",
                      table(["quantity", "mean", "sd", "median", "5 %", "95 %"], rows))


def _add_stem(section: Section, results: CalibrationResults, number: int, stem: dict):
    section.heading(f"Stem {stem['measurement']}")
    if "stem" in stem:  # not in files of older versions
        section.paragraph(f"{stem['stem']}.")
    section.add(table(PARAMETER_COLUMNS, parameter_rows(stem["parameters"])))
    _add_budget(section, f"budget-{number:03}", stem)
    _add_study(section, stem)
    try:
        time, heights, measured, predicted = results.prediction(number)
    except CalibrationError as error:
        section.note(str(error))
        return
    name, residual = f"{number:03}", measured - predicted
    models = [("fitted chain", predicted, VERMILLION)]
    section.add_plots(motion_plots(name, time, heights, measured, models),
                      motion_caption(stem["fit"]["noise_mm"], stem["fit"]["noise_source"]),
                      legend=legend_of(models))
    if len(heights) > 1:
        section.add_plots([map_plot(f"map-{name}", "measured − fitted, mm", time, heights, residual,
                                    colour_limit(residual))],
                          "Residuals over time and height: blue below zero, red above. A good fit "
                          "leaves noise, which has no pattern; stripes are motion that the chain lacks.")
        add_animation(section, name, time, heights, measured, [("fitted chain", predicted)])


def _add_budget(section: Section, name: str, stem: dict):
    """The part of each input in the standard uncertainty of Y, beta and the effects' parameters."""
    if "uncertainty_budget" not in stem:  # written by an older version
        return
    budget, known = stem["uncertainty_budget"], stem["parameters"]
    keys = [key for key in known if key not in RELEASE and known[key]["value"]
            and budget["combined"][key] is not None]
    inputs = [entry["name"] for entry in budget["inputs"]]
    traces, rows = [], [[entry["name"], entry["value"] or None, entry["unit"] or "share",
                         entry["standard_uncertainty"], entry["default"], entry["pull"]]
                        for entry in budget["inputs"]]
    rows.append(["noise of the readings", None, "", None, False, None])
    for key, colour in zip(keys, cycle((*SERIES, ORANGE, BLACK))):
        parts = [abs(entry["sensitivities"][key] * entry["standard_uncertainty"])
                 for entry in budget["inputs"]]
        parts.append(budget["readings"]["standard_uncertainties"][key])
        shares = [100.0 * part / abs(known[key]["value"]) for part in parts]
        traces.append({"type": "bar", "x": [*inputs, "readings"], "y": shares,
                       "name": NAMES.get(key, key),
                       "marker": {"color": colour}})
        for row, share in zip(rows, shares):
            row.append(share)
    section.add_plots([Plot(name, "", "The part of each input in the standard uncertainty.", traces,
                            layout(axis(), axis("standard uncertainty, %")), 260)],
                      "Uncertainty budget: the standard uncertainty that each input causes, as a "
                      "share of the value. The root of the sum of squares, times 1.96, is the ± of the "
                      "table. The longest bar is the input that is worth measuring better. "
                      + " ".join(budget["sentences"]),
                      table(["input", "stated", "unit", "u", "default", "pull",
                             *(f"{NAMES.get(key, key)}, %" for key in keys)], rows))


def _add_study(section: Section, stem: dict):
    via = stem.get("via")
    if via and "failure" not in via:
        rows = [[law, *(with_error(via[key][member], factor) if via[key][member] else "–"
                        for key, _, factor in QUANTITIES[:2])]
                for law, member in (("Eqs. 12 and 13", "single_law"),
                                    ("terms kept by F-tests", "f_test_terms"))]
        section.add(table([f"by the study {via['study']}", "Y, GPa", "β"], rows))
        for warning in via["warnings"]:
            section.note(warning)
    if via and "failure" in via:
        section.note(via["failure"])
    for remark in stem.get("remarks", []):
        section.note(remark)
    section.add(folded("Tests for lack of fit", table(
        ["test", "p", "p, adjusted for their number"],
        [[test["name"], test["p_value"], test["adjusted_p_value"]]
         for test in stem["fit"]["tests"]])))


def _add_provenance(section: Section, results: CalibrationResults):
    section.heading("Provenance and cost")
    rows = [[name.replace("_", " "), "–" if value in (None, "") else value]
            for name, value in results.content["options"].items()]
    stems = [stem for stem in results.stems if "failure" not in stem]
    rows += [["batches of lanes", sum(stem["fit"]["runs"] for stem in stems)],
             ["readings", sum(stem["fit"]["readings"] for stem in stems)]]
    rows += [[f"recording of {stem['measurement']}", stem.get("folder", "–")]
             for stem in results.stems]
    rows += provenance_rows(results.content)
    section.add(facts(rows))
    for remark in results.content.get("remarks", []):
        section.note(remark)
