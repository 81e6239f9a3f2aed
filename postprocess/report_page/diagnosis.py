# SPDX-License-Identifier: BSD-3-Clause
"""A diagnosis: which effect is missing, with what certainty, and what the recording cannot detect."""
from __future__ import annotations

from culm.checked_hdf5 import StudyError
from command_results import Diagnosis
from palette import BLUE, VERMILLION
from report_page.drawing import axis, dots, layout, level, line, log_axis
from report_page.explanations import add_explanations
from report_page.markup import (Plot, Section, escaped, facts, folded, half_width,
                                provenance_rows, shown, table)
from report_page.measured import (AMPLITUDE_CAPTION, PARAMETER_COLUMNS, WHERE_CAPTION,
                                  WITH_FREE_INPUTS, add_motion, amplitude_plots, amplitude_table,
                                  colour_limit, contradictions, legend_of, map_array, map_plot,
                                  parameter_rows, read_motion, where_plots, where_table)

MOST_RECORDINGS = 3


def diagnosis_section(diagnosis: Diagnosis, key: str, place: str) -> Section:
    """The section of a folder of `culm diagnose -o`."""
    content = diagnosis.content
    section = Section(key, f"Diagnosis of {content['measurement']} ({place})")
    section.tone = "good" if content["verdict"] in ("adequate", "effect") else "doubt"
    section.verdict += content["sentences"]
    section.heading("Residual by model")
    _add_ladder(section, content)
    _add_missing_force(section, content)
    add_explanations(section, content)
    _add_blind_spots(section, diagnosis)
    _add_next(section, content)
    _add_where(section, content)
    _add_motion(section, diagnosis)
    _add_provenance(section, content)
    return section


def ladder_labels(ladder: list[dict]) -> list[str]:
    """The first model, and what each of the others adds to the one before."""
    added = [[name for name in rung["model"] if name not in before["model"]]
             for before, rung in zip(ladder, ladder[1:])]
    return [" + ".join(ladder[0]["model"]), *("+ " + " + ".join(names) for names in added)]


def _add_ladder(section: Section, content: dict):
    ladder = content["ladder"]
    labels = ladder_labels(ladder)
    noise = content["noise_mm"]
    errors = [rung["rmse_mm"] for rung in ladder]
    trace = dots(errors, labels, "residual", BLUE, 11, mode="lines+markers+text",
                 text=[f"{shown(error, 3)} mm" for error in errors],
                 hoverinfo="x+y", line={"color": BLUE, "width": 1})
    ends = [value for value in [*errors, noise] if value]
    look = layout(log_axis("residual, mm (rms)", ends),
                  axis(type="category", range=[len(ladder) - 0.5, -0.7]),
                  legend=False, levels=[level(noise, VERMILLION, "dash", "x")] if noise else [])
    rows = [[" + ".join(rung["model"]), rung["rmse_mm"], rung["reduced_chi2"],
             rung.get("log_evidence"), contradictions(rung), rung["finding"]]
            for rung in ladder]
    section.add_plots([Plot("ladder", "", "Residual of every model on the way to the answer.",
                            [trace], look, 130 + 52 * len(ladder))],
                      "The rms of the residuals of each model on the way to the answer. The dashed line "
                      "is the noise. The last model is good if it is near this line.")
    section.add(table(["model", "rms, mm", "reduced chi²*", "log evidence*", "contradicted inputs",
                       "verdict*"], rows, WITH_FREE_INPUTS))
    section.add(table(PARAMETER_COLUMNS, parameter_rows(content["parameters"]),
                      "Parameters of the best model"))
    section.add(folded("Parameters of the published chain alone", table(
        PARAMETER_COLUMNS, parameter_rows(content["baseline"]["parameters"]))))


def _add_missing_force(section: Section, content: dict):
    force = content["missing_force"]
    if not force or not force["form"]:
        return
    is_moment = force["kind"] == "bending_moment"
    member, label = (("moment_n_m", "bending moment, N m") if is_moment
                     else ("force_n_per_m", "force per length, N/m"))
    plots = []
    curves = (("against_displacement", "displacement_mm", "displacement of the tip, mm"),
              ("against_velocity", "velocity_m_s", "velocity of the tip, m/s"))
    largest = 1.08 * max(abs(sample[member]) for curve, _, _ in curves for sample in force[curve])
    for curve, quantity, title in curves:
        samples = force[curve]
        plots.append(Plot(f"force-{curve.replace('_', '-')}", "", f"Missing {label} {curve} of the "
                          "tip.", [line([s[quantity] for s in samples], [s[member] for s in samples],
                                        "", BLUE, width=2)],
                          layout(axis(title, zeroline=True),
                                 axis(label, zeroline=True, range=[-largest, largest]),
                                 legend=False)))
    section.heading("The missing force")
    section.add_plots(plots, f"{force['form']}; {force['character']}. x is the deflection, v its "
                             "rate, kappa the curvature, all in SI units. A straight line through zero "
                             "is a linear force; a bend or a step shows what the chain lacks.",
                      table(["term", "coefficient", "± (95 %)", "probability"],
                            [[term["term"], term["coefficient"], shown(half_width(term["stderr"]), 2),
                              term["probability"]] for term in force["terms"]]))
    section.add(folded("The same as an effect of your own (missing_force.toml)",
                       f"<pre>{escaped(force['effect_file'])}</pre>"))


def _add_blind_spots(section: Section, diagnosis: Diagnosis):
    spots = sorted(diagnosis.visible_spots, key=lambda spot: -_largest_bias(spot))
    section.heading("Blind spots: effects below their detection limit")
    content = diagnosis.content
    others = [spot["effect"] for spot in content["blind_spots"] if spot not in spots]
    if spots:
        names = [spot["effect"] for spot in spots]
        traces = [{"type": "bar", "orientation": "h", "name": label, "y": names,
                   "x": [100.0 * (spot["bias"][key] or 0.0) for spot in spots],
                   "marker": {"color": colour}, "hoverinfo": "x+y"}
                  for key, label, colour in (("bond_youngs_modulus", "bias of Y, %", BLUE),
                                             ("bond_damping", "bias of β, %", VERMILLION))]
        section.add_plots([Plot("blind-spots", "", "Bias of Y and beta by an effect at its "
                                "detection limit.", traces,
                                layout(axis("bias, %",
                                            zeroline=True),
                                       axis(type="category", autorange="reversed")),
                                120 + 30 * len(spots))],
                          "The error of Y and β that an effect of the size of its detection limit "
                          "causes. A smaller effect can act undetected. A long bar is a reason for "
                          "another experiment; a short one is harmless.")
        section.add(table(["effect", "detection limit", "unit", "bias of Y, %", "bias of β, %"],
                          [[f"{spot['effect']}: {spot['smallest_visible']['parameter']}",
                            spot["smallest_visible"]["value"], spot["smallest_visible"]["unit"],
                            _percent(spot["bias"]["bond_youngs_modulus"]),
                            _percent(spot["bias"]["bond_damping"])] for spot in spots]))
    if others:
        section.note(f"Undetectable at any size: {', '.join(others)}.")


def _largest_bias(spot: dict) -> float:
    return max(abs(spot["bias"][key] or 0.0) for key in ("bond_youngs_modulus", "bond_damping"))


def _percent(share):
    return None if share is None else 100.0 * share


def _add_next(section: Section, content: dict):
    if not content["next_experiment"]:
        return
    section.heading("Suggested experiments, most informative first")
    rows = [[entry["what"], " from ".join(" + ".join(model) for model in entry["separates"]),
             None if entry["expected_gap"] is None else entry["expected_gap"] ** 0.5]
            for entry in content["next_experiment"]]
    section.add(table(["experiment", "distinguishes", "distance, standard deviations"], rows))


def _add_where(section: Section, content: dict):
    section.heading("Residuals of the best model")
    wheres = content.get("where_by_recording") or [content["where"]]
    recordings = content["recordings"]
    for place, (where, recording) in enumerate(zip(wheres[:MOST_RECORDINGS], recordings)):
        residuals = map_array(where["residual_map"])
        if residuals.ndim == 2 and residuals.shape[1] > 1:
            entry = where["residual_map"]
            section.add_plots([map_plot(f"map-{place}", f"{recording['id']}: measured − modelled, mm",
                                        entry["time_s"], entry["height_mm"], residuals,
                                        colour_limit(residuals))],
                              "Residuals over time and height: blue below zero, red above. A good "
                              "model leaves noise, which has no pattern.")
    label = " + ".join(content["ladder"][-1]["model"])
    first = [(label, wheres[0], VERMILLION)]
    section.add_plots(where_plots(first), WHERE_CAPTION,
                      where_table(wheres[0]), legend_of(first))
    plots = amplitude_plots(first)
    if plots:
        section.add_plots(plots, AMPLITUDE_CAPTION, amplitude_table(wheres[0]), legend_of(first))


def table_name(place: int) -> str:
    """The file of the motion of recording number `place`."""
    return "deflections.csv" if place == 0 else f"deflections_{place + 1}.csv"


def _add_motion(section: Section, diagnosis: Diagnosis):
    """Draws the motion of the published chain and of the best model for the first MOST_RECORDINGS
    recordings."""
    recordings = diagnosis.content["recordings"]
    for place, recording in enumerate(recordings[:MOST_RECORDINGS]):
        try:
            motion = read_motion(diagnosis.file.parent / table_name(place))
        except StudyError as refusal:
            section.note(str(refusal))
            return
        if motion is None:
            continue
        section.heading(f"The motion{'' if len(recordings) == 1 else ' of ' + recording['id']}")
        add_motion(section, str(place), motion, motion.models[0][0], motion.models[-1][0],
                   recording["noise_mm"])


def _add_provenance(section: Section, content: dict):
    section.heading("Provenance and cost")
    rows = [[f"recording {recording['id']}",
             f"{recording['folder']}: {recording['frames']} frames, {recording['heights']} heights, "
             f"noise {shown(recording['noise_mm'], 3)} mm ({recording['noise_source']})"]
            for recording in content["recordings"]]
    rows.append(["batches of lanes", content["runs"]])
    for name, value in content["options"].items():
        text = ", ".join(value) if isinstance(value, list) else value
        rows.append([name.replace("_", " "), "–" if text in (None, "") else text])
    section.add(facts(rows + provenance_rows(content)))
    for remark in content["remarks"]:
        section.note(remark)
