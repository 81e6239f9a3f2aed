# SPDX-License-Identifier: BSD-3-Clause
"""The points of a design, one of which can be picked, and the history of the picked point."""
from __future__ import annotations

import base64

import numpy as np

from culm.archive import Study
from design_map import SMALLEST_SHARE_OF_GRID
from palette import BLACK, BLUE, GREY, ORANGE, number
from report_page.drawing import (MOST_MARKERS, SEQUENTIAL, axis, chosen_rows, dots,
                                 heat_map, layout, line)
from report_page.markup import Plot, Section, data_script, escaped, table
from study_points import DAMPING_KEY, YOUNGS_MODULUS_KEY, StudyPoints, fit_window

MOST_HISTORIES = 160
MOST_SAMPLES = 600
SAMPLES_PER_CYCLE = 20
FULL_SCALE = 32000  # of a sample in 16 bits


def packed(values: np.ndarray) -> dict:
    """Numbers as 16-bit integers in base64: base64 text and scale; NaN becomes -32768."""
    largest = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 0.0
    scale = largest / FULL_SCALE or 1.0
    rounded = np.where(np.isfinite(values), np.round(values / scale), -32768).astype("<i2")
    return {"scale": scale, "values": base64.b64encode(rounded.tobytes()).decode("ascii")}


def kept_samples(time: np.ndarray, fastest_hz: float) -> np.ndarray:
    """Indices of at most MOST_SAMPLES samples from the first on. Many samples are thinned, but to
    no fewer than SAMPLES_PER_CYCLE; samples beyond MOST_SAMPLES are then cut off."""
    spacing = float(np.median(np.diff(time)))
    thinnest = max(1, int(1.0 / (SAMPLES_PER_CYCLE * fastest_hz * spacing)))
    wanted = -(-time.size // MOST_SAMPLES)
    return np.arange(0, time.size, min(wanted, thinnest))[:MOST_SAMPLES]


def varying_factors(study: Study) -> list[str]:
    """Y and β first, if they vary."""
    names = [name for name, values in study.factors.items() if np.unique(values).size > 1]
    first = [name for name in (YOUNGS_MODULUS_KEY, DAMPING_KEY) if name in names]
    return first + [name for name in names if name not in first]


def add_picker(section: Section, study: Study, points: StudyPoints):
    """Draws the design; if the study stores histories, that of the picked point is shown."""
    names = (varying_factors(study) or list(study.factors) or [])[:2]
    if not names:
        return
    design, ids = _design_plot(study, points, names)
    if not study.stores_tip or not points.id.size:
        section.add_plots([design], _design_caption(study, ids) + " This study stores no "
                          "histories (store = \"tip\" keeps them).")
        return
    kept = points.id[_spread_rows(points.id.size)]
    samples = kept_samples(study.time, float(points.frequency.max()))
    histories, facts = _histories(study, kept, samples)
    empty = Plot("history", "History of the tip", "Deflection of the tip of the picked point "
                 "against time, with the fit of Eq. 1.",
                 [line([], [], "simulated", BLUE), line([], [], "Eq. 1, fitted", BLACK, "dot", 1.2)],
                 layout(axis("time since the release, ms"), axis("deflection of the tip, mm")), 400)
    content = {"ids": ids, "facts": facts, "time": packed(1e3 * study.time[samples]),
               "window_ms": 1e3 * fit_window(study), "histories": histories,
               "design": f"{section.key}-design", "history": f"{section.key}-history"}
    caption = _design_caption(study, ids) + _history_caption(study, kept, samples, points)
    section.add(f"<div class=\"picker\">{data_script(content, 'picker-data')}{_controls(section.key)}"
                f"{section.figure([design, empty], caption, _factor_table(study, points))}</div>")


def _controls(key: str) -> str:
    return (f"<div class=\"controls\"><label for=\"{escaped(key)}-point\">Point</label> "
            f"<button type=\"button\" class=\"previous\" aria-label=\"previous point\">◀</button> "
            f"<select id=\"{escaped(key)}-point\"></select> "
            f"<button type=\"button\" class=\"next\" aria-label=\"next point\">▶</button> "
            f"<output class=\"facts\" aria-live=\"polite\"></output></div>")


def _spread_rows(count: int) -> np.ndarray:
    """At most MOST_HISTORIES rows, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST_HISTORIES)).round().astype(int))


def _design_plot(study: Study, points: StudyPoints, names: list[str]):
    """The drawing, and the ids of the points of each of its traces: a list, or rows of cells."""
    horizontal = study[names[0]]
    vertical = study[names[1]] if len(names) > 1 else study["frequency"]
    label = _axis_label(study, names[1]) if len(names) > 1 else "frequency b2, Hz"
    cells = _cells(points, horizontal, vertical) if points.id.size > MOST_MARKERS else None
    traces, ids = ([cells[0]], [cells[1]]) if cells else _markers(points, horizontal, vertical)
    for status, colour, symbol in (("failed", ORANGE, "x"), ("missing", GREY, "circle-open")):
        which = np.flatnonzero(study.statuses == status)
        which = which[chosen_rows(np.zeros(which.size))]
        if which.size and len(names) > 1:
            traces.append(dots(horizontal[which], vertical[which], status, colour, 9, symbol,
                               text=[f"point {point}: {status}" for point in which],
                               hoverinfo="x+y+text"))
            ids.append(which.tolist())
    traces.append(dots([], [], "picked", "rgba(0,0,0,0)", 16, "circle", showlegend=False))
    traces[-1]["marker"]["line"] = {"color": BLACK, "width": 2}
    ids.append([])
    title = "The design: pick a point" if study.stores_tip else "The design"
    return Plot("design", title, "The points of the design; the control above chooses one.", traces,
                layout(axis(_axis_label(study, names[0])), axis(label)), 400), ids


def _markers(points: StudyPoints, horizontal, vertical):
    rows = chosen_rows(np.zeros(points.id.size))
    chosen = points.id[rows]
    trace = dots(horizontal[chosen], vertical[chosen], "with a fit", BLUE, 9,
                 text=[f"point {point}: b2 = {number(points.frequency[row])} Hz"
                       for point, row in zip(chosen, rows)], hoverinfo="x+y+text")
    trace["marker"] |= {"color": points.frequency[rows], "colorscale": SEQUENTIAL,
                        "colorbar": "b2, Hz"}
    return [trace], [chosen.tolist()]


def _cells(points: StudyPoints, horizontal, vertical):
    """A map of a large factorial design with the ids of its cells; None for any other design."""
    x, column = np.unique(horizontal[points.id], return_inverse=True)
    y, row = np.unique(vertical[points.id], return_inverse=True)
    if np.unique(row * x.size + column).size != points.id.size or (
            points.id.size < SMALLEST_SHARE_OF_GRID * x.size * y.size):
        return None
    values, ids = np.full((y.size, x.size), np.nan), np.full((y.size, x.size), -1)
    values[row, column], ids[row, column] = points.frequency, points.id
    return heat_map(x, y, values, "b2, Hz"), ids.tolist()


def factor_name(name: str) -> str:
    """A factor's key as words, without its unit."""
    for key, words in ((DAMPING_KEY, "bond damping β"),
                       (YOUNGS_MODULUS_KEY, "bond Young's modulus Y")):
        if name == key:
            return words
    for ending in ("_mm", "_gpa", "_kg_m3"):
        name = name.removesuffix(ending)
    return name.replace("_", " ")


def _axis_label(study: Study, name: str) -> str:
    unit = study.unit(name)
    return factor_name(name) if unit == "1" else f"{factor_name(name)}, {unit}"


def _histories(study: Study, kept: np.ndarray, samples: np.ndarray):
    """The deflection of the tip in mm and the fit of Eq. 1 for every kept point."""
    time, window = study.time, fit_window(study)
    in_window = (time >= 0.0) & (time <= window)
    amplitude, rate, frequency = (study[name] for name in ("amplitude", "decay_rate", "frequency"))
    per_cycle, rms = study["decay_per_cycle"], study["rms_residual"]
    histories, facts = {}, {}
    for point in kept.tolist():
        tip = 1e3 * study.tip_deflection(point)
        scale = float(np.max(np.abs(tip[in_window])))
        histories[point] = {**packed(tip[samples]), "b0": float(amplitude[point] * scale),
                            "b1": float(rate[point]), "b2": float(frequency[point])}
        given = ", ".join(f"{name} = {number(values[point])}"
                          for name, values in study.factors.items())
        facts[point] = (f"{given}: b2 = {number(frequency[point])} Hz, b1 = "
                        f"{number(per_cycle[point])} per cycle; residual of Eq. 1 "
                        f"{number(100.0 * rms[point], 2)} % (rms)")
    return histories, facts


def _design_caption(study: Study, ids: list) -> str:
    drawn = sum(np.count_nonzero(np.asarray(part) >= 0) for part in ids)
    return "" if drawn >= study.points else f"{drawn} of {study.points} points are drawn."


def _history_caption(study: Study, kept, samples, points: StudyPoints) -> str:
    text = " Click a point, or choose it by the control above; the arrows step through all of them."
    if kept.size < points.id.size:
        text += (f" The histories of {kept.size} of {points.id.size} points are on this page, "
                 "evenly spread; a click shows the nearest of them.")
    step = samples[1] - samples[0] if samples.size > 1 else 1
    if step > 1:
        text += f" One of every {step} samples is shown."
    if samples[-1] + step < study.time.size:
        text += f" The first {number(1e3 * study.time[samples[-1]], 3)} ms are shown."
    return text


def _factor_table(study: Study, points: StudyPoints) -> str:
    names = list(study.factors)
    rows = [[int(point), *(float(study.factors[name][point]) for name in names),
             float(points.frequency[row]), float(points.decay_per_cycle[row])]
            for row, point in enumerate(points.id[:200])]
    return table(["point", *names, "b2, Hz", "b1 per cycle"], rows,
                 f"{len(rows)} of {points.id.size} points; Study(\"DIR\").table() has all.")
