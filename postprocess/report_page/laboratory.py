# SPDX-License-Identifier: BSD-3-Clause
"""A laboratory: effects that many stems share, and Y and beta of stems with and without them."""
from __future__ import annotations

import math
from pathlib import Path

from command_results import Laboratory
from palette import BLACK, BLUE, GREY, VERMILLION
from report_page.drawing import axis, dots, layout, line
from report_page.explanations import add_explanations
from report_page.laboratory_power import add_power, counted_stems, probability_text
from report_page.markup import (Markup, Plot, Section, escaped, facts, folded, half_width,
                                provenance_rows, shown, table, value_and_error)
from report_page.recordings import link_to, read_recordings, scale_of, sparkline

OUTLIER_DISTANCE = 3.5  # diagnose::outlier_distance, robust standard deviations
MOST_JOINED = 60  # stems whose two values a line joins
NO_BREAK = "\N{NO-BREAK SPACE}"
QUANTITIES = (("Y", "youngs_modulus", "_pa", 1e-9, "GPa"), ("β", "damping", "", 1.0, ""))
SIDES = (("before", "published chain", BLUE, 1), ("after", "with the effects", VERMILLION, 0))


def laboratory_section(laboratory: Laboratory, page_folder: Path, key: str, place: str) -> Section:
    """The section of a folder of `culm diagnose -o` for several specimens."""
    content = laboratory.content
    section = Section(key, f"Laboratory of {counted_stems(len(content['stems']))} ({place})")
    section.tone = "good" if content["conclusion"] in ("adequate", "effect") else "doubt"
    section.verdict += [*content["sentences"], *_counts(laboratory)]
    add_explanations(section, content)
    _add_effects(section, content)
    add_power(section, laboratory)
    _add_stems(section, laboratory, page_folder)
    _add_population(section, laboratory)
    _add_limits(section, content)
    _add_provenance(section, content)
    return section


def _ratio(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _signed(percent: float) -> str:
    return f"+{shown(percent, 2)}" if percent > 0.0 else shown(percent, 2)


def _counts(laboratory: Laboratory) -> list[str]:
    """Sentences on the stems that were left out and on those that nothing explains."""
    sentences = []
    if laboratory.left_out:
        names = ", ".join(stem["specimen"] for stem in laboratory.left_out)
        of_all = counted_stems(len(laboratory.content["stems"]))
        sentences.append(f"{len(laboratory.left_out)} of {of_all} left out: {names}.")
    unlike = [stem["specimen"] for stem in laboratory.stems
              if stem["finding"] == "inadequate" or _outliers(stem)]
    if unlike:
        sentences.append(f"Not explained, or far from the others: {', '.join(unlike)}.")
    return sentences


def _add_effects(section: Section, content: dict):
    section.heading("Effects of the rigs")
    rows = []
    for effect in content["rig_effects"]:
        probability = "known" if effect["known"] else probability_text(effect["probability"])
        family = (f"{effect['family']}: {probability_text(effect['family_probability'])}"
                  if effect["family"] and not effect["known"] else "–")
        head = [effect["effect"], effect["rig"], probability, family]
        for each in effect["parameters"]:
            low, high = (shown(end) for end in each["interval_95"])
            rows.append([*head, each["name"], f"{shown(each['value'])} {each['unit']}".rstrip(),
                         f"{low} to {high} {each['unit']}".rstrip()])
        if not effect["parameters"]:
            rows.append([*head, "–", "not in the best model", "–"])
    if rows:
        section.add(table(["effect", "rig", "probability", "probability of its family", "parameter",
                           "value", "95 % interval"], rows))
    else:
        section.paragraph("None was found or stated.")
    section.heading("Effects of stems")
    if content["stem_effects"]:
        count = sum(not stem.get("failure") for stem in content["stems"])
        section.add(table(["effect", "probability", "probability of its family", "number of stems",
                           "stems that have it", "possible in"],
                          [[each["effect"], probability_text(each["probability"]),
                            f"{each['family']}: {probability_text(each['family_probability'])}",
                            f"{len(each['specimens'])} of {count}", ", ".join(each["specimens"]),
                            ", ".join(each["possible_specimens"])]
                           for each in content["stem_effects"]]))
    else:
        section.paragraph("None was found.")


def _outliers(stem: dict) -> list[str]:
    """"Y: −4.2 deviations from the median" for each quantity that is far from it."""
    return [f"{name}: {shown(stem[f'{member}_distance'], 2)} deviations from the median"
            for name, member, _, _, _ in QUANTITIES
            if abs(stem[f"{member}_distance"] or 0.0) > OUTLIER_DISTANCE]


def _estimate(stem: dict, side: str, quantity: tuple) -> tuple[float, float]:
    """Value and half width of its 95 % interval; NaN where the document has none."""
    _, member, unit, factor, _ = quantity
    known = stem[side][f"bond_{member}{unit}"], stem[side][f"bond_{member}_standard_error{unit}"]
    value, error = (math.nan if each is None else factor * each for each in known)
    return value, half_width(error)


def _with_width(value: float, width: float) -> str:
    if math.isnan(value):
        return "–"
    texts = value_and_error(value, None if math.isnan(width) else width)
    return " ± ".join(text for text in texts if text).replace(" ", NO_BREAK)


def _add_stems(section: Section, laboratory: Laboratory, page_folder: Path):
    content = laboratory.content
    recordings = read_recordings(content, laboratory.file)
    scale = scale_of(recordings)
    rows = []
    for stem in content["stems"]:
        own = [each for each in recordings if each.specimen == stem["specimen"]]
        links = [link_to(each, stem["specimen"] if len(own) == 1 else each.folder.name, page_folder)
                 for each in own if each.folder]
        name = escaped(stem["specimen"]) if len(links) != 1 else ""
        head = [Markup(" ".join([name, *links]).strip()),
                Markup("".join(sparkline(each, scale) for each in own) or "–"), stem["rig"]]
        if stem.get("failure"):
            rows.append([*head, *["–"] * 6, "left out", Markup(
                f"<strong>left out</strong>: {escaped(stem['failure'])}")])
            continue
        marks = [f"<strong>{escaped(text)}</strong>" for text in _outliers(stem)]
        marks += [escaped(text) for text in _own_effects(stem)]
        values = [_with_width(*_estimate(stem, side, quantity))
                  for quantity in QUANTITIES for side, _, _, _ in SIDES]
        finding = stem["finding"] + (f" ({stem['failed_tests']})" if stem["failed_tests"] else "")
        rows.append([*head, *values, _ratio(stem["over_noise_before"]), _ratio(stem["over_noise"]),
                     finding, Markup("<br>".join(marks) or "–")])
    section.heading("The stems")
    section.add(table(["stem", "deflection", "rig", "Y before, GPa", "Y after, GPa", "β before",
                       "β after", "residual before", "residual after", "finding",
                       "own effects, remarks"], rows))
    start, end, largest = scale
    note = ("Before: the published chain; after: with the effects. ± is half of the 95 % interval. "
            "Residuals are in units of the noise. "
            f"Far from the others: more than {OUTLIER_DISTANCE} robust standard deviations of the "
            "logarithm from the median.")
    if largest > 0.0:
        note += (f" The small drawings show the deflection at the highest row, all from "
                 f"{shown(1e3 * start, 3)} to {shown(1e3 * end, 3)} ms and to ±{shown(largest, 3)} "
                 "mm.")
    unread = sum(not each.time_s.size for each in recordings)
    if unread:
        note += (f" {unread} of {len(recordings)} recordings are not drawn: not found, changed "
                 "since they were diagnosed, or without a row of a camera.")
    section.note(note)


def _own_effects(stem: dict) -> list[str]:
    """The names of the effects of this stem alone, and their parameters with ± (95 %)."""
    values = []
    for each in stem["own_parameters"]:
        width = half_width(each["standard_error"])
        values.append(f"{each['name']} " + _with_width(
            *(math.nan if number is None else number for number in (each["value"], width))))
    return [text for text in (", ".join(stem["own_effects"]), *values) if text]


def _add_population(section: Section, laboratory: Laboratory):
    population = laboratory.content["population"]
    section.heading("Y and β of all stems, without and with the effects")
    plots, rows = [], []
    for quantity in QUANTITIES:
        name, member, unit, factor, shown_unit = quantity
        label = f"{name}, {shown_unit}" if shown_unit else name
        samples = [population[side][f"bond_{member}{unit}"] for side, _, _, _ in SIDES]
        means = [_scaled(sample["mean"], factor) for sample in samples]
        scatters = [_scaled(sample["standard_deviation"], factor) for sample in samples]
        change = 100.0 * (means[1] / means[0] - 1.0) if means[0] else math.nan
        section.paragraph(f"{name}: mean {shown(means[0])} {shown_unit}".rstrip() +
                          f", scatter {shown(scatters[0], 3)} before; {shown(means[1])}, "
                          f"{shown(scatters[1], 3)} after ({_signed(change)} % in the mean).")
        rows.append([label, means[0], scatters[0], means[1], scatters[1], change])
        plots.append(Plot(f"strip-{member.replace('_', '-')}", label,
                          f"{name} of every stem before and after, with mean and scatter.",
                          _strip(laboratory.stems, quantity, means, scatters),
                          layout(axis(label), axis(range=[-0.7, 1.3], tickvals=[0, 1],
                                                   ticktext=["after", "before"], fixedrange=True),
                                 legend=False), 250))
    joined = "; a line joins its two values" if len(laboratory.stems) <= MOST_JOINED else ""
    section.add_plots(plots, "Each dot is a stem, in the published chain (before) and with the "
                             f"effects (after){joined}. Below the dots the mean and the scatter "
                             "(standard deviation) of the stems.",
                      table(["quantity", "mean before", "scatter before", "mean after",
                             "scatter after", "change of the mean, %"], rows))
    before, after = (shown(population[side]["correlation"], 2) for side, _, _, _ in SIDES)
    section.paragraph(f"Correlation of Y and β: {before} before, {after} after.")
    section.add_plots([Plot("scatter", "", "Beta against Y of every stem, before and after.",
                            _scatter(laboratory.stems), layout(axis("Y, GPa"), axis("β")))],
                      "β against Y with 95 % intervals. If their correlation vanishes with the "
                      "effects, leaving these out can have caused it. A diamond marks a stem far "
                      "from the others.")


def _scaled(value: float | None, factor: float) -> float:
    return math.nan if value is None else factor * value


def _strip(stems: list, quantity: tuple, means: list, scatters: list) -> list[dict]:
    """Dots of both sides, lines between them, and mean ± scatter below each."""
    values = {side: [_estimate(stem, side, quantity)[0] for stem in stems] for side, *_ in SIDES}
    traces = []
    if len(stems) <= MOST_JOINED:
        joined = [end for pair in zip(values["before"], values["after"]) for end in (*pair, None)]
        traces.append(line(joined, [1, 0, None] * len(stems), "", GREY, width=1, hoverinfo="skip"))
    for (side, name, colour, height), mean, scatter in zip(SIDES, means, scatters):
        traces.append(dots(values[side], [height] * len(stems), name, colour, 7, text=[
            f"{stem['specimen']}: {shown(value)}" for stem, value in zip(stems, values[side])],
            hoverinfo="text"))
        traces.append(dots([mean], [height - 0.45], "", BLACK, 8, "diamond", mode="markers+text",
                           text=[f"mean {shown(mean)}, scatter {shown(scatter, 3)}"],
                           hoverinfo="text", error_x={"array": [scatter], "color": BLACK}))
    return traces


def _scatter(stems: list) -> list[dict]:
    traces = []
    for (side, name, colour, _), symbol in zip(SIDES, ("circle-open", "circle")):
        (x, x_width), (y, y_width) = (
            tuple(zip(*(_estimate(stem, side, quantity) for stem in stems))) or ((), ())
            for quantity in QUANTITIES)
        traces.append(dots(x, y, f"{side}: {name}", colour, 7, symbol, hoverinfo="text",
                           text=[stem["specimen"] for stem in stems],
                           error_x={"array": x_width, "color": colour},
                           error_y={"array": y_width, "color": colour}))
    far = [stem for stem in stems if _outliers(stem)]
    if far:
        x, y = ([_estimate(stem, "after", quantity)[0] for stem in far] for quantity in QUANTITIES)
        traces.append(dots(x, y, "far from the others", BLACK, 15, "diamond-open", hoverinfo="text",
                           mode="markers+text", text=[stem["specimen"] for stem in far]))
    return traces


def _add_limits(section: Section, content: dict):
    if not content["detection_limits"]:
        return
    section.heading("Detection limits of effects that are not in the answer")
    section.add(table(["effect", "rig", "parameter", "unit", "all stems", "one stem"],
                      [[each["effect"], each["rig"], each["parameter"], each["unit"] or "–",
                        each["all_stems"], each["one_stem"]]
                       for each in content["detection_limits"]]))
    section.note("3 standard deviations. An effect of a rig below the limit of all stems can act "
                 "undetected; the limit of one stem is that of the median stem alone.")


def _add_provenance(section: Section, content: dict):
    section.heading("Provenance and cost")
    rows = [["recordings", ", ".join(content["folders"]) or "–"]]
    for name, value in content["options"].items():
        text = ", ".join(value) if isinstance(value, list) else value
        rows.append([name.replace("_", " "), "–" if text in (None, "") else text])
    section.add(facts(rows + provenance_rows(content)))
