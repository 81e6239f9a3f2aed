# SPDX-License-Identifier: BSD-3-Clause
"""Measurements: a tracked video, and Eq. 1 fitted to measured stems."""
from __future__ import annotations

import base64
from pathlib import Path

import numpy as np

from backbones import SENTENCES, law_curve, law_text
from command_results import (PUBLISHED_B1_PER_CYCLE, PUBLISHED_B2_HZ, FitResults, TrackResults,
                             heights_of)
from histogram import histogram_of
from palette import BLACK, BLUE, GREEN, ORANGE, VERMILLION
from report_page.drawing import axis, bars, dots, layout, level, line
from report_page.markup import Plot, Section, facts, provenance_rows, shown, table
from report_page.measured import backbone_plots, backbone_table, map_plot

LARGEST_PICTURE = 3_000_000  # bytes of a contact sheet that the page carries
STEM_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, BLACK, "#CC79A7")
STEM_SYMBOLS = ("circle", "square-open", "diamond", "triangle-up", "x")
MOST_STEMS = 12  # drawn along the height
MOST_BACKBONES = 6  # stems whose backbones are drawn
UNITS = {"mm": "mm", "px": "px", "hz": "Hz", "pa": "Pa", "fps": "1/s"}


def recording_section(track: TrackResults, key: str, place: str) -> Section:
    """The section of a folder of `culm track -o`."""
    tracked, release = track.content, track.content["release"]
    section = Section(key, f"Recording of {track.stem} ({place})")
    section.verdict.append(
        f"{tracked['frames_tracked']} frames at {shown(tracked['fps'])} frames/s were tracked; the "
        f"tip was pulled by {shown(release['pull_mm'])} mm at {shown(release['pull_at_height_mm'])}"
        f" mm and swings at {shown(tracked['swing_hz'])} Hz.")
    rows = _rows(tracked)
    for group in ("view", "contrast", "release"):
        rows += _rows(tracked[group], f"{group}: ")
    noises = [[row["height_mm"], row["noise_mm"], row["moving_noise_mm"],
               f"{100.0 * row['seen']:.1f} %"] for row in tracked["heights"]]
    _add_contact_sheet(section, track.directory / "contact_sheet.png")
    largest = float(np.nanmax(np.abs(track.deflection_mm)))
    section.add_plots([map_plot("deflection", "Deflection, mm", track.time_s, track.heights_mm,
                                track.deflection_mm, largest)],
                      "Deflection over time and height: red towards the pull, blue away from it. A good "
                      "recording has smooth vertical stripes that fade; an isolated cell is a "
                      "reading to check.",
                      table(["height, mm", "noise, mm", "noise while moving, mm", "seen"], noises))
    section.add(facts(rows))
    return section


def _rows(group: dict, prefix: str = "") -> list:
    """The plain members of a group as names and values."""
    def named(key: str) -> str:
        words, _, last = key.rpartition("_")
        is_unit = words and last in UNITS and not words.endswith("_per")
        return f"{words}, {UNITS[last]}".replace("_", " ") if is_unit else key.replace("_", " ")

    return [[prefix + named(name), value] for name, value in group.items()
            if not isinstance(value, (dict, list))]


def _add_contact_sheet(section: Section, file: Path):
    """Adds the picture unless it is a symbolic link, which may lead to any file of the machine."""
    if file.is_symlink() or not file.is_file():
        return
    if file.stat().st_size > LARGEST_PICTURE:
        section.note(f"{file.name} has {file.stat().st_size / 1e6:.1f} MB, too many for this page; "
                     "open it in the folder of the recording.")
        return
    picture = base64.b64encode(file.read_bytes()).decode("ascii")
    section.add(f"<figure><img alt=\"Contact sheet: frames of the video with the tracked axis drawn "
                f"in, and all histories\" src=\"data:image/png;base64,{picture}\"><figcaption>The "
                "contact sheet. The tracked axis must lie on the stem in every frame, and the histories "
                "below must be smooth.</figcaption></figure>")


def fit_section(results: FitResults, key: str, place: str) -> Section:
    """The section of a folder of `culm fit -o`."""
    section = Section(key, f"Eq. 1 fitted to measured stems ({place})")
    stems = results.fitted()
    population = results.population
    if population:
        section.verdict.append(
            f"{population['stems']} stems: b1 per cycle {shown(population['b1_per_cycle']['mean'], 3)}"
            f" (sd {shown(population['b1_per_cycle']['standard_deviation'], 2)}), b2 "
            f"{shown(population['b2_hz']['mean'], 3)} Hz (sd "
            f"{shown(population['b2_hz']['standard_deviation'], 2)}); the paper's 29 stems: −0.46 "
            "(0.17) and 64.6 Hz (21.2).")
    else:
        section.verdict += [f"{stem['measurement']}: b1 per cycle "
                            f"{shown(stem['b1_per_cycle']['value'])}, b2 "
                            f"{shown(stem['b2_hz']['value'])} Hz." for stem in stems]
    section.add(table(
        ["stem", "b1 per cycle", "b2, Hz", "heights that Eq. 1 fits", "heights", "largest deflection, mm"],
        [[stem["measurement"], stem["b1_per_cycle"]["value"], stem["b2_hz"]["value"],
          stem["adequate_heights"], len(stem["heights"]), stem["largest_deflection_mm"]]
         for stem in stems]))
    if population:
        _add_population(section, population, stems)
    if stems:
        _add_banding(section, stems)
    _add_backbones(section, [stem for stem in results.stems if stem.get("backbone")])
    provenance = provenance_rows(results.content)
    if provenance:
        section.heading("Provenance and cost")
        section.add(facts(provenance))
    return section


def _add_population(section: Section, population: dict, stems: list[dict]):
    plots = []
    for name, label, (mean, deviation) in (
            ("b1_per_cycle", "b1 per cycle", PUBLISHED_B1_PER_CYCLE),
            ("b2_hz", "b2, Hz", PUBLISHED_B2_HZ)):
        entry = population[name]
        counts, edges = histogram_of([stem[name]["value"] for stem in stems])
        most = max(counts)
        published = line([mean - deviation, mean + deviation], [1.06 * most] * 2,
                         "paper: mean ± sd", VERMILLION, width=3)
        middle = dots([mean], [1.06 * most], "paper: mean", VERMILLION, 9, "diamond",
                      showlegend=False)
        plots.append(Plot(f"population-{name.replace('_', '-')}", label, f"Histogram of {label}.",
                          [bars(counts, edges, "stems"), published,
                           middle],
                          layout(axis(label), axis("stems", whole=True),
                                 levels=[level(entry["mean"], BLACK, "dash", "x")]), 280))
    section.add_plots(plots, "Number of stems against b1 and b2, as in the paper's Fig. 5. The dashed line is "
                             "the mean of these stems. The red bar is the paper's mean ± its standard "
                             "deviation; similar stems lie around it.")


def _add_banding(section: Section, stems: list):
    traces = []
    for place, stem in enumerate(stems[:MOST_STEMS]):
        heights = heights_of(stem)
        colour = STEM_COLOURS[place % len(STEM_COLOURS)]
        traces.append(dots([height["height_mm"] / stem["length_mm"] for height in heights],
                           [height["b1_per_cycle"]["value"] for height in heights],
                           stem["measurement"], colour, 7,
                           STEM_SYMBOLS[place % len(STEM_SYMBOLS)], mode="lines+markers",
                           line={"color": colour, "width": 1}))
    caption = ("b1 against the height over the length, as in the paper's Fig. 6a. Eq. 1 with one b1 "
               "needs a level line; a slope shows that b1 depends on the height. Near the clamp readings are small and "
               "b1 is uncertain.")
    if len(stems) > MOST_STEMS:
        caption += f" {MOST_STEMS} of {len(stems)} stems."
    section.add_plots([Plot("banding", "", "Decay per cycle against height over length.", traces,
                            layout(axis("height / length"), axis("b1 per cycle")))], caption)


def _add_backbones(section: Section, stems: list):
    """Frequency and damping ratio of every mode against its amplitude, with the fitted laws."""
    if not stems:
        return
    section.heading("Against the amplitude")
    for place, stem in enumerate(stems[:MOST_BACKBONES]):
        for backbone in stem["backbone"]:
            title = f"{stem['measurement']}, mode {backbone['mode']}"
            if backbone["signature"]:
                section.paragraph(f"{title}: {SENTENCES[backbone['signature']]}")
            if not backbone["laws"]:
                section.paragraph(f"{title}: no laws, because {backbone['reason']}.")
            if backbone["points"]:
                _add_backbone(section, backbone, title, f"backbone-{place}-{backbone['mode']}")
    if len(stems) > MOST_BACKBONES:
        section.note(f"{MOST_BACKBONES} of {len(stems)} stems.")


def _add_backbone(section: Section, backbone: dict, title: str, name: str):
    def law(key: str) -> list[dict]:
        if not backbone["laws"]:
            return []
        return [line(*law_curve(backbone, key), law_text(backbone["laws"], key), VERMILLION)]

    legend = (("measured", BLACK, "dots"), ("fitted law", VERMILLION, "solid"))
    section.add_plots(backbone_plots(backbone, law, name, "measured, with the fitted law"),
                      f"{title}: frequency and damping ratio against the amplitude at "
                      f"{shown(backbone['height_mm'])} mm, in windows of eight cycles, with 95 % "
                      "intervals. A level line means that nothing depends on the amplitude.",
                      backbone_table(backbone["points"]),
                      legend if backbone["laws"] else legend[:1])
