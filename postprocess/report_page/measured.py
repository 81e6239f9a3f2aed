# SPDX-License-Identifier: BSD-3-Clause
"""Measurement against model: the motion, the residuals and their location, and the moving stem."""
from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from backbones import QUANTITIES, amplitude_label, column, points_of
from culm.checked_hdf5 import StudyError, sentence
from command_results import numbers
from palette import BLACK, BLUE, GREY, VERMILLION, number
from report_page.drawing import axis, dots, heat_map, layout, level, line, log_axis, thinned
from report_page.markup import (Plot, Section, data_script, escaped, half_width, shown,
                                table, value_and_error)
from report_page.picker import packed

FIRST, LAST = BLUE, VERMILLION  # of the smallest and the largest model
ANIMATED_CYCLES_MS = 1e3  # of the record that the moving stem shows
MOST_FRAMES = 500
WITH_FREE_INPUTS = ("* with the inputs free within their uncertainties; all else with every input "
                    "as stated")
LARGEST_PART = 0.995  # share of the residuals within the colour scale of a map


@dataclass
class Motion:
    """Deflections of one recording, mm, from deflections.csv of culm compare or diagnose."""

    time_s: np.ndarray  # (T)
    heights_mm: np.ndarray  # (H)
    measured_mm: np.ndarray  # (T, H); NaN where nothing was seen
    models: list  # (name, predicted (T, H)), the published chain first


def contradictions(fit: dict) -> str:
    """Inputs that the readings pull by more than 3 standard uncertainties: "clamp height +44.2"."""
    return ", ".join(f"{entry['name']} {entry['pull']:+.1f}".replace(" -", " \N{MINUS SIGN}")
                     for entry in fit.get("contradicted_inputs", []))


def read_motion(file: Path) -> Motion | None:
    """None if the file is missing; a StudyError if it is not a table of deflections."""
    if not file.is_file() or file.is_symlink():
        return None
    try:
        with file.open(encoding="utf-8") as lines:
            names, *rows = csv.reader(lines)
        table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
        columns = [name.rsplit(" h=", 1) for name in names[1:]]
        labels = list(dict.fromkeys(label for label, _ in columns))
        heights = [float(height.removesuffix("mm")) for _, height in columns[::len(labels)]]
        values = table[:, 1:].reshape(len(table), len(heights), len(labels))
        return Motion(table[:, 0], np.array(heights), values[:, :, 0],
                      [(label, values[:, :, k]) for k, label in enumerate(labels) if k > 0])
    except (OSError, IndexError, ValueError, UnicodeError) as error:
        raise StudyError(f"{file}: not readable as the motion of a recording: "
                         f"{sentence(error)}") from error


def map_plot(name: str, title: str, time_s, heights_mm, residual_mm, largest: float) -> Plot:
    """Residuals (T, H) over height and time; `largest` is the end of the colours, mm."""
    time, kept, group = thinned(np.asarray(time_s, float), np.asarray(residual_mm, float))
    remark = f" (of {group} frames the largest)" if group > 1 else ""
    return Plot(name, title + remark, f"Map of {title} over height and time.",
                [heat_map(1e3 * time, heights_mm, kept.T, "mm", largest)],
                layout(axis("time, ms"), axis("height, mm"), legend=False), 260)


def map_array(residual_map: dict) -> np.ndarray:
    """The residuals of a member `residual_map`, (T, H), mm."""
    return np.array([numbers(row) for row in residual_map["residual_mm"]], dtype=float)


def colour_limit(*arrays: np.ndarray) -> float:
    """A common scale for several maps that covers nearly all residuals of the first map."""
    known = np.abs(arrays[0][np.isfinite(arrays[0])])
    return float(np.quantile(known, LARGEST_PART)) if known.size else 1.0


def motion_plots(name: str, time_s, heights_mm, measured_mm, models: list) -> list[Plot]:
    """The motion of the row that moves most, and the residual of each model; models: (label,
    predicted (T, H), colour)."""
    measured = np.asarray(measured_mm, dtype=float)
    swing = np.nanmax(np.abs(np.where(np.isfinite(measured), measured, 0.0)), axis=0)
    row = int(np.argmax(swing))
    time = 1e3 * np.asarray(time_s, dtype=float)
    upper = [dots(time, measured[:, row], "measured", BLACK, 4)]
    lower = []
    for label, predicted, colour in models:
        upper.append(line(time, predicted[:, row], label, colour, dash_of(colour), 1.2))
        lower.append(line(time, measured[:, row] - predicted[:, row], label, colour,
                          dash_of(colour), 1.0))
    where = f"at h = {number(heights_mm[row])} mm"
    return [Plot(f"motion-{name}", f"Deflection {where}", f"Measured and modelled deflection {where} "
                 "against time.", upper,
                 layout(axis("time, ms"), axis("deflection, mm"), legend=False)),
            Plot(f"left-{name}", f"Measured − modelled {where}", f"Residuals of the models {where} "
                 "against time.", lower,
                 layout(axis("time, ms"), axis("residual, mm"), legend=False))]


def dash_of(colour: str) -> str:
    """The smallest model is dashed: a second mark besides its colour."""
    return "dash" if colour == FIRST else "solid"


def legend_of(models: list) -> tuple:
    """Legend of drawings with measured dots and lines of models; models: (label, any, colour)."""
    return (("measured", BLACK, "dots"),
            *((label, colour, "dashed" if colour == FIRST else "solid")
              for label, _, colour in models))


def add_motion(section: Section, name: str, motion: Motion, first: str, last: str, noise_mm):
    """Draws the measured motion and that of two models; animates stems with several heights."""
    colours = {first: FIRST, last: LAST}
    chosen = [(label, predicted, colours[label]) for label, predicted in motion.models
              if label in colours]
    section.add_plots(motion_plots(name, motion.time_s, motion.heights_mm, motion.measured_mm,
                                   chosen),
                      motion_caption(noise_mm), legend=legend_of(chosen))
    if np.size(motion.heights_mm) > 1:
        add_animation(section, name, motion.time_s, motion.heights_mm, motion.measured_mm,
                      motion.models)


def motion_caption(noise_mm, source: str = "") -> str:
    return ("The height that moves most. Dots are the readings and lines the models. A good model runs "
            f"through the dots, and its residuals are as large as the noise ({shown(noise_mm, 3)} mm rms"
            f"{', ' + source if source else ''}) without a pattern.")


def add_animation(section: Section, name: str, time_s, heights_mm, measured_mm, models: list):
    """The stem in slow motion: measured dots over the modelled stem; models: (label, predicted)."""
    time = np.asarray(time_s, dtype=float)
    frames = np.flatnonzero(time <= time[0] + 1e-3 * ANIMATED_CYCLES_MS)[:MOST_FRAMES]
    measured = np.asarray(measured_mm, dtype=float)[frames]
    largest = float(np.nanmax(np.abs(measured))) or 1.0
    heights = np.asarray(heights_mm, dtype=float)
    place = f"{section.key}-stem-{name}"
    content = {"plot": place, "frames": int(frames.size), "heights": heights,
               "time": packed(1e3 * time[frames]), "measured": packed(measured),
               "models": [{"name": label, **packed(np.asarray(predicted, float)[frames])}
                          for label, predicted in models]}
    look = layout(axis("deflection, mm", range=[-1.15 * largest, 1.15 * largest], fixedrange=True),
                  axis("height, mm", range=[0.0, 1.06 * float(heights.max())], fixedrange=True))
    traces = [line([], [], "modelled", VERMILLION, width=3), dots([], [], "measured", BLACK, 9)]
    traces[0]["line"]["shape"] = "spline"
    plot = Plot(f"stem-{name}", "The stem in slow motion", "The measured positions over the "
                "modelled stem at one moment; play it or move the slider.", traces, look, 420)
    caption = ("Deflection against height above the clamp. Dots are the readings. The line is the "
               "model through the same heights. The scales of the axes differ.")
    if frames.size < time.size:
        caption += f" The first {frames.size} of {time.size} frames."
    section.add(f"<div class=\"animation\">{data_script(content, 'animation-data')}"
                f"{_animation_controls(place, content['models'], frames.size)}"
                f"{section.figure([plot], caption)}</div>")


def _animation_controls(place: str, models: list, frames: int) -> str:
    place = escaped(place)
    choices = "".join(f"<option value=\"{k}\"{' selected' if k == len(models) - 1 else ''}>"
                      f"{escaped(model['name'])}</option>" for k, model in enumerate(models))
    speeds = "".join(f"<option value=\"{s}\"{' selected' if s == 100 else ''}>1 : {s}</option>"
                     for s in (20, 50, 100, 200, 500))
    return (f"<div class=\"controls\"><button type=\"button\" class=\"play\">Play</button> "
            f"<label for=\"{place}-time\">Time</label> <input id=\"{place}-time\" type=\"range\" "
            f"min=\"0\" max=\"{frames - 1}\" value=\"0\" class=\"moment\"> "
            f"<label for=\"{place}-speed\">Slowed down</label> <select id=\"{place}-speed\" "
            f"class=\"speed\">{speeds}</select> "
            f"<label for=\"{place}-model\">Model</label> <select id=\"{place}-model\" "
            f"class=\"model\">{choices}</select> <output class=\"facts\"></output></div>")


def backbone_plots(backbone: dict, curves, name: str = "amplitude",
                   sides: str = "measured and modelled") -> list[Plot]:
    """Frequency and damping ratio of one mode against its amplitude; `curves`: a key → traces."""
    points = backbone["points"]
    amplitudes = column(points, "amplitude_mm")
    plots = []
    for key, error, label in QUANTITIES:
        trace = dots(amplitudes, column(points, key), "measured", BLACK, 7)
        trace["error_y"] = {"type": "data", "array": [half_width(point[error]) for point in points],
                            "thickness": 1, "color": BLACK}
        plots.append(Plot(f"{name}-{key.replace('_', '-')}", label,
                          f"{label} against amplitude, {sides}.", [trace, *curves(key)],
                          layout(log_axis(amplitude_label(backbone), amplitudes), axis(label),
                                 legend=False)))
    return plots


def amplitude_plots(wheres: list) -> list[Plot]:
    """The backbone of mode 1; wheres: (label, member `where`, colour). The measured values are those
    of the last one."""
    measured = wheres[-1][1]["backbone"]["measured"]
    if not points_of(measured):
        return []

    def modelled(key: str) -> list[dict]:
        models = [(name, points_of(where["backbone"]["modelled"]), colour)
                  for name, where, colour in wheres]
        return [line(column(points, "amplitude_mm"), column(points, key), name, colour,
                     dash_of(colour), mode="lines+markers", marker={"color": colour, "size": 4})
                for name, points, colour in models if points]

    return backbone_plots(measured[0], modelled)


def amplitude_table(where: dict) -> str:
    return backbone_table(points_of(where["backbone"]["measured"]))


def backbone_table(points: list[dict]) -> str:
    rows = [[1e3 * point["time_s"], point["amplitude_mm"], point["frequency_hz"],
             point["damping_ratio"]] for point in points]
    return table(["middle of the window, ms", "amplitude", "frequency, Hz", "damping ratio"], rows)


def where_plots(wheres: list) -> list[Plot]:
    """Residuals along the stem and over frequency; wheres as in amplitude_plots."""
    heights, spectrum, banding = [], [], []
    for name, where, colour in wheres:
        groups = where["by_height"]
        heights.append(line(numbers([group["rms_over_noise"] for group in groups]),
                            [group["height_mm"] for group in groups], name, colour,
                            dash_of(colour)))
        spectrum.append(line(where["spectrum"]["frequency_hz"],
                             numbers(where["spectrum"]["power_over_noise"]), name, colour,
                             dash_of(colour), 1.1))
        known = [height for height in where["banding"]["heights"] if height["modelled"]]
        banding.append(line([height["modelled"]["value"] for height in known],
                            [height["height_mm"] for height in known], name, colour,
                            dash_of(colour)))
    known = [height for height in wheres[-1][1]["banding"]["heights"] if height["measured"]]
    measured = dots([height["measured"]["value"] for height in known],
                    [height["height_mm"] for height in known], "measured", BLACK, 7)
    measured["error_x"] = {"type": "data", "thickness": 1, "color": BLACK,
                           "array": [half_width(height["measured"]["stderr"]) for height in known]}
    powers = [value for _, where, _ in wheres for value in where["spectrum"]["power_over_noise"]]
    largest = max([1.0, *(group["rms_over_noise"] or 0.0 for _, where, _ in wheres
                          for group in where["by_height"])])
    modes = wheres[-1][1]["spectrum"]["mode_frequencies_hz"]
    return [Plot("by-height", "Residual along the stem", "Residual over noise against height.",
                 heights, layout(axis("residual / noise", range=[0.0, 1.08 * largest]),
                                 axis("height, mm"), legend=False, levels=[level(1.0, along="x")])),
            Plot("banding", "b1 along the stem", "Decay per cycle against height, measured and "
                 "modelled.", [measured, *banding],
                 layout(axis("decay per cycle b1"), axis("height, mm"), legend=False)),
            Plot("spectrum", "Spectrum of the residuals", "Power of the residuals over that of the "
                 "noise against frequency; grey lines: the modes of the fitted chain.", spectrum,
                 layout(axis("frequency, Hz"), log_axis("power / noise", [1.0, *powers]), legend=False,
                        levels=[level(1.0, GREY, "dash"),
                                *(level(mode, GREY, "solid", "x") for mode in modes)]))]


WHERE_CAPTION = ("Residual along the stem: the rms of the residuals over the noise against the height; the "
                 "grey line at 1 is the noise. b1 along the stem: dots with 95 % intervals are measured, "
                 "lines are modelled. Spectrum: the power of the residuals over that of the noise; the dashed "
                 "grey line at 1 is the noise, and solid grey lines are the natural frequencies of the "
                 "fitted chain. A good model stays near 1. A peak at a natural frequency shows that this "
                 "mode is modelled wrongly.")
AMPLITUDE_CAPTION = ("The backbone: frequency and damping ratio of mode 1 against its amplitude, in windows of "
                     "eight cycles. Dots with 95 % intervals are measured, lines are modelled and read in the same way. A good model "
                     "passes through the intervals. A slope of the dots that a line lacks shows a missing "
                     "dependence on the amplitude.")


def where_table(where: dict) -> str:
    rows = [[f"h = {shown(group['height_mm'])} mm", group["rms_mm"], group["rms_over_noise"]]
            for group in where["by_height"]]
    rows += [[f"{1e3 * group['begin_s']:.0f} … {1e3 * group['end_s']:.0f} ms", group["rms_mm"],
              group["rms_over_noise"]] for group in where["by_time"]]
    return table(["where", "rms, mm", "over the noise"], rows)


def parameter_rows(parameters: dict) -> list:
    """Name, value with its 95 % half width, unit, remark; in units that suit a stem."""
    rows = []
    for name, entry in parameters.items():
        factor, unit = READABLE.get(unit_of(name, entry), (1.0, unit_of(name, entry)))
        value, error = entry["value"], entry["stderr"]
        texts = ("–", "") if value is None else value_and_error(factor * value, half_width(error, factor))
        rows.append([NAMES.get(name, name), texts[0], texts[1] or "–", unit,
                     "at its bound" if entry.get("at_bound") else ""])
    return rows


NAMES = {"bond_youngs_modulus_pa": "bond Young's modulus Y", "bond_damping": "bond damping β",
         "tip_deflection_m": "tip deflection", "release_time_s": "release time"}
READABLE = {"Pa": (1e-9, "GPa"), "m": (1e3, "mm"), "s": (1e3, "ms")}
PARAMETER_COLUMNS = ["parameter", "value", "± (95 %)", "unit", ""]


def unit_of(name: str, entry: dict) -> str:
    """The unit stated in the document, or the fixed unit of a known name."""
    known = {"bond_youngs_modulus_pa": "Pa", "tip_deflection_m": "m", "release_time_s": "s"}
    return entry.get("unit") or known.get(name.split("@")[0], "")
