#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the laboratory figures from a folder of `culm fit -o DIR`: fit_figures.py DIR [-o OUT].

Writes histories (Fig. 3c), population (Fig. 5) and banding (Fig. 6) of Schramm et al. (2019) to OUT
(default: DIR) and prints each path. Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

import sys
from pathlib import Path

from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figures
from figure_style import (BLUE, COLOUR_MAP, GREY, VERMILLION, FigureSkipped, colour_bar, mark,
                          new_figure, number, styled)
from fit_results import FitError, FitResults, heights_of
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize


@styled
def histories_figure(results: FitResults, stem_number: int = 0):
    """Fig. 3c: time in cycles, deflection over the stem's largest one, at every height."""
    stem = results.stems[stem_number]
    if "b2_hz" not in stem:
        raise FigureSkipped(f"no height of {stem['measurement']} could be fitted.")
    cycles, deflections = results.normalised(stem_number)
    figure = new_figure(2.8, f"{stem['measurement']}: b2 = {number(stem['b2_hz']['value'])} Hz, "
                             f"b1 = {number(stem['b1_per_cycle']['value'], 3)} per cycle")
    axes = figure.subplots()
    heights = [float(name[2:-2]) for name in deflections]
    colours = colormaps[COLOUR_MAP]
    for height, values in zip(heights, deflections.values()):
        axes.plot(cycles, values, color=colours(height / stem["length_mm"]), linewidth=0.8)
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0)
    axes.set(xlabel="time, cycles", ylabel="deflection / largest deflection",
             xlim=(cycles[0], min(cycles[-1], 12.0)))
    shown = ScalarMappable(Normalize(0.0, stem["length_mm"]), colours)
    colour_bar(figure, shown, axes, "height above the clamp, mm", heights)
    return figure


def draw_histogram(axes, sample: dict, label: str):
    edges, counts = sample["histogram"]["edges"], sample["histogram"]["counts"]
    axes.stairs(counts, edges, fill=True, color=BLUE, alpha=0.75)
    axes.axvline(sample["mean"], color=VERMILLION, linewidth=1.0)
    axes.set(xlabel=label, ylabel="stems",
             title=f"mean {number(sample['mean'], 3)}, sd {number(sample['standard_deviation'], 2)}")


@styled
def population_figure(results: FitResults):
    """Fig. 5: histograms of b1 per cycle and of b2."""
    if results.population is None:
        raise FigureSkipped("one stem is no population.")
    figure = new_figure(2.6, "")
    left, right = figure.subplots(1, 2)
    draw_histogram(left, results.population["b1_per_cycle"], "b1 per cycle")
    draw_histogram(right, results.population["b2_hz"], "b2, Hz")
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
    """Fig. 6: b1 per cycle against the relative height, and against the aspect ratio."""
    stems = results.fitted()
    if len(stems) < 2:
        raise FigureSkipped("one stem is no population.")
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
    left.set(xlabel="height / length", ylabel="b1 per cycle")
    right.set(xlabel="length / diameter", ylabel="b1 per cycle")
    mark(left, "a")
    mark(right, "b")
    return figure


FIGURES = {
    "histories": histories_figure,
    "population": population_figure,
    "banding": banding_figure,
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
