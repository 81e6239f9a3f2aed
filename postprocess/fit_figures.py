#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the laboratory figures from a folder of `culm fit -o DIR`: fit_figures.py DIR [-o OUT].

Writes histories, population and banding (Figs. 3b and c, 5 and 6 of Schramm et al., 2019), and
backbone for `culm fit --backbone`, to OUT (default: DIR) and prints each path. Exit codes: 0 done,
2 bad input.
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "matplotlib")

import sys
from pathlib import Path

import numpy as np

from backbones import QUANTITIES, amplitude_label, draw_points, law_curve, law_text
from command_results import (PUBLISHED_B1_PER_CYCLE, PUBLISHED_B2_HZ, FitError, FitResults,
                             TrackResults, heights_of)
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figures
from figure_style import (FigureSkipped, colour_bar, leave_room_above, mark, new_figure, styled,
                          whole_numbers)
from histogram import histogram_of
from palette import BLACK, BLUE, COLOUR_MAP, GREY, VERMILLION, number
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, ScalarFormatter

MOST_CYCLES = 12.0  # shown in the histories
MODE_COLOURS = (BLUE, VERMILLION)


@styled
def displacements_figure(track: TrackResults):
    """Fig. 3a: deflection against time at every height, for all frames that culm track kept,
    including those in which the stem was held; a line marks the release."""
    release = track.content["release"]
    figure = new_figure(2.8, f"{track.stem}: {number(track.content['fps'])} frames/s, pulled by "
                             f"{number(release['pull_mm'], 3)} mm at "
                             f"{number(release['pull_at_height_mm'])} mm")
    axes = figure.subplots()
    colours = colormaps[COLOUR_MAP]
    heights = track.heights_mm
    scale = Normalize(0.0, max(heights))
    for row, height in enumerate(heights):
        axes.plot(1e3 * track.time_s, track.deflection_mm[:, row], color=colours(scale(height)),
                  linewidth=0.8)
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0)
    axes.axvline(0.0, color=VERMILLION, linewidth=0.8, linestyle="--", label="release")
    axes.set(xlabel="time, ms", ylabel="deflection, mm",
             xlim=(1e3 * np.min(track.time_s), 1e3 * np.max(track.time_s)))
    axes.legend(loc="upper right")
    colour_bar(figure, ScalarMappable(scale, colours), axes, "height above the clamp, mm", heights)
    return figure


@styled
def histories_figure(results: FitResults, stem_number: int = 0):
    """Fig. 3b and c: deflection at every height against time from just before the release, and
    relative to the stem's largest deflection against cycles."""
    stem = results.stems[stem_number]
    if "b2_hz" not in stem:
        raise FigureSkipped(f"no height of {stem['measurement']} could be fitted.")
    cycles, deflections = results.normalised(stem_number)
    figure = new_figure(2.8, f"{stem['measurement']}: b2 = {number(stem['b2_hz']['value'])} Hz, "
                             f"b1 = {number(stem['b1_per_cycle']['value'], 3)} per cycle")
    in_time, in_cycles = figure.subplots(1, 2)
    heights = [float(name[2:-2]) for name in deflections]
    colours = colormaps[COLOUR_MAP]
    period_ms, scale = 1e3 / stem["b2_hz"]["value"], stem["largest_deflection_mm"]
    for height, values in zip(heights, deflections.values()):
        colour = colours(height / stem["length_mm"])
        in_time.plot([period_ms * cycle for cycle in cycles], [scale * value for value in values],
                     color=colour, linewidth=0.8)
        in_cycles.plot(cycles, values, color=colour, linewidth=0.8)
    last = min(cycles[-1], MOST_CYCLES)
    in_time.set(xlabel="time, ms", ylabel="deflection, mm",
                xlim=(period_ms * cycles[0], period_ms * last))
    in_cycles.set(xlabel="time, cycles", ylabel="deflection / largest deflection",
                  xlim=(cycles[0], last))
    for axes, letter in ((in_time, "b"), (in_cycles, "c")):
        axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0)
        mark(axes, letter)
    shown = ScalarMappable(Normalize(0.0, stem["length_mm"]), colours)
    colour_bar(figure, shown, in_cycles, "height above the clamp, mm", heights)
    return figure


def draw_histogram(axes, values: list[float], sample: dict, label: str,
                   published: tuple[float, float]):
    """Histogram with its mean as a dashed line and the published mean ± deviation above it."""
    counts, edges = histogram_of(values)
    axes.stairs(counts, edges, fill=True, color=BLUE, alpha=0.75)
    axes.plot([sample["mean"]] * 2, [0.0, max(counts)], color=BLACK, linewidth=0.8, linestyle="--")
    mean, deviation = published
    axes.errorbar([mean], [1.08 * max(counts)], xerr=[deviation], fmt="D", markersize=4,
                  color=VERMILLION, elinewidth=1.5, label="Schramm et al. (2019), mean ± sd")
    axes.legend(loc="upper left")
    leave_room_above(axes, 0.15)
    whole_numbers(axes.yaxis)
    axes.set(xlabel=label, ylabel="stems",
             title=f"mean {number(sample['mean'], 3)}, sd {number(sample['standard_deviation'], 2)}")


@styled
def population_figure(results: FitResults):
    """Fig. 5: histograms of b1 per cycle and of b2, with the published mean and spread."""
    if results.population is None:
        raise FigureSkipped("a population needs more than one stem.")
    figure = new_figure(2.6, "")
    left, right = figure.subplots(1, 2)
    for axes, name, label, published in ((left, "b1_per_cycle", "b1 per cycle",
                                          PUBLISHED_B1_PER_CYCLE),
                                         (right, "b2_hz", "b2, Hz", PUBLISHED_B2_HZ)):
        draw_histogram(axes, [stem[name]["value"] for stem in results.fitted()],
                       results.population[name], label, published)
    mark(left, "a")
    mark(right, "b")
    return figure


def draw_decays(axes, places, fits, **style):
    """b1 per cycle of stems or heights with its 95 % interval."""
    decays = [fit["b1_per_cycle"] for fit in fits]
    axes.errorbar(places, [decay["value"] for decay in decays],
                  yerr=[decay["interval"][1] - decay["value"] for decay in decays], **style)


@styled
def banding_figure(results: FitResults):
    """Fig. 6: b1 per cycle against the relative height and against the aspect ratio; a line in a
    band shows the published mean and spread of the stems."""
    stems = results.fitted()
    if len(stems) < 2:
        raise FigureSkipped("a population needs more than one stem.")
    figure = new_figure(2.8, "")
    left, right = figure.subplots(1, 2)
    colours = colormaps[COLOUR_MAP]
    for index, stem in enumerate(stems):
        heights = heights_of(stem)
        draw_decays(left, [h["height_mm"] / stem["length_mm"] for h in heights], heights,
                    fmt="o-", markersize=2, linewidth=0.5, elinewidth=0.3,
                    color=colours(index / max(1, len(stems) - 1)))
    draw_decays(right, [stem["aspect_ratio"] for stem in stems], stems, fmt="o", markersize=3,
                color=BLUE, elinewidth=0.6)
    mean, deviation = PUBLISHED_B1_PER_CYCLE
    for axes in (left, right):
        axes.axhspan(mean - deviation, mean + deviation, color=VERMILLION, alpha=0.12, linewidth=0,
                     zorder=0)
        axes.axhline(mean, color=VERMILLION, linewidth=0.8, linestyle="--", zorder=0,
                     label="Schramm et al. (2019), mean ± sd")
    right.legend()
    left.set(xlabel="height / length", ylabel="b1 per cycle")
    right.set(xlabel="length / diameter", ylabel="b1 per cycle")
    mark(left, "a")
    mark(right, "b")
    return figure


def draw_backbone(axes, backbone: dict, key: str, error: str):
    """Windows of one mode with 95 % intervals, and the law through them."""
    colour = MODE_COLOURS[backbone["mode"] - 1]
    if backbone["laws"]:
        axes.plot(*law_curve(backbone, key), color=BLACK, linewidth=0.8,
                  label=law_text(backbone["laws"], key))
    draw_points(axes, backbone["points"], key, error, fmt="o", markersize=3, color=colour,
                elinewidth=0.6,
                label=f"mode {backbone['mode']} at {number(backbone['height_mm'])} mm")
    leave_room_above(axes, 0.25)
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[::-1], labels[::-1], loc="upper left")
    axes.set_xscale("log")
    axes.get_xaxis().set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.get_xaxis().set_major_formatter(FuncFormatter(lambda value, _: number(value)))
    axes.get_xaxis().set_minor_formatter(NullFormatter())
    axes.get_yaxis().set_major_formatter(ScalarFormatter(useOffset=False))


@styled
def backbone_figure(results: FitResults, stem_number: int = 0):
    """Frequency and damping ratio of modes 1 and 2 against their amplitude, with the laws."""
    stem = results.stems[stem_number]
    if "backbone" not in stem:
        raise FigureSkipped("culm fit ran without --backbone.")
    shown = [backbone for backbone in stem["backbone"] if backbone["points"]]
    if not shown:
        raise FigureSkipped(f"{stem['measurement']} has no window of eight cycles that shows a "
                            "mode.")
    signature = shown[0]["signature"]
    figure = new_figure(0.4 + 2.4 * len(shown), f"{stem['measurement']}: windows of eight cycles, "
                        "95 % intervals" + (f"; signature: {signature}" if signature else ""))
    panels = figure.subplots(len(shown), 2, squeeze=False)
    for row, backbone in zip(panels, shown):
        for axes, (key, error, label) in zip(row, QUANTITIES):
            draw_backbone(axes, backbone, key, error)
            axes.set(xlabel=amplitude_label(backbone), ylabel=label)
    for axes, letter in zip(panels.flat, "abcd"):
        mark(axes, letter)
    return figure


TRACK_FIGURES = {"displacements": displacements_figure}
FIGURES = {
    "histories": histories_figure,
    "population": population_figure,
    "banding": banding_figure,
    "backbone": backbone_figure,
}


def parse(arguments):
    parser = OneSentenceParser(prog="fit_figures.py", description="Figures of measured stems.")
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder of culm fit -o")
    add_output_options(parser, "DIR")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)

    def draw():
        results = FitResults(options.directory)
        write_figures("fit_figures.py", FIGURES, results, options.out or results.directory,
                      options.format)

    return exit_code_of("fit_figures.py", (FitError,), draw)


if __name__ == "__main__":
    sys.exit(main())
