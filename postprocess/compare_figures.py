#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws where and how models fail: compare_figures.py FILE_OR_DIR [-o OUT].

FILE was written by `culm compare --json`, DIR by `culm compare -o`. Writes ladder, residuals (maps
over height and time), spectrum, amplitude (frequency, decay and rest against amplitude) and heights
(residuals and b1 along the stem) to OUT (default: the folder of the file) and prints each
path. Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "h5py", "matplotlib")

import sys
from pathlib import Path

import numpy as np

from backbones import QUANTITIES, amplitude_label, draw_points, points_of
from command_results import Comparison, ComparisonError, name_of, numbers
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figures
from figure_style import FigureSkipped, leave_room_above, literal, mark, new_figure, styled
from palette import BLACK, BLUE, GREY, VERMILLION, number
from matplotlib.ticker import NullFormatter, ScalarFormatter

MOST_MAPS = 3
TICKS = (1, 1.5, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000)  # of residual / noise
FIRST, LAST = BLUE, VERMILLION


def first_and_last(comparison: Comparison) -> list[tuple[dict, str]]:
    """The smallest and the largest model with their colours; a single model is listed once."""
    rungs = comparison.rungs
    return [(rungs[0], FIRST)] + ([(rungs[-1], LAST)] if len(rungs) > 1 else [])


@styled
def ladder_figure(comparison: Comparison):
    """Residual over noise of every model."""
    rungs = comparison.rungs
    if len(rungs) < 2:
        raise FigureSkipped("a ladder needs more than one model.")
    figure = new_figure(1.0 + 0.5 * len(rungs), comparison.measurement)
    axes = figure.subplots()
    places = np.arange(len(rungs))[::-1]
    axes.plot(numbers([rung["rmse_over_noise"] for rung in rungs]), places, "o", color=BLUE,
              markersize=5)
    axes.axvline(1.0, color=GREY, linewidth=0.8, zorder=0)
    axes.set_xscale("log")
    axes.set_yticks(places, [rung_label(rung) for rung in rungs])
    axes.set(xlabel="residual / noise", ylim=(-0.6, len(rungs) - 0.4))
    largest = max(rung["rmse_over_noise"] for rung in rungs)
    axes.set_xticks([tick for tick in TICKS if tick <= 2.0 * largest])
    axes.get_xaxis().set_major_formatter(ScalarFormatter())
    axes.get_xaxis().set_minor_formatter(NullFormatter())
    return figure


def rung_label(rung: dict) -> str:
    gain = {True: ": a gain", False: ": no gain"}.get(rung.get("gain"), "")
    return literal(" + ".join(rung["added"] or rung["model"])) + gain


@styled
def residuals_figure(comparison: Comparison):
    """Residuals of the first models and of the last one over height and time, on one scale."""
    rungs = comparison.rungs
    rungs = rungs if len(rungs) <= MOST_MAPS else [*rungs[:MOST_MAPS - 1], rungs[-1]]
    maps = [rung["where"]["residual_map"] for rung in rungs]
    if len(maps[0]["height_mm"]) < 2:
        raise FigureSkipped("a map needs more than one height.")
    figure = new_figure(0.7 + 1.4 * len(rungs), comparison.measurement)
    panels = figure.subplots(len(rungs), 1, sharex=True, squeeze=False)[:, 0]
    values = [np.array([numbers(row) for row in shown["residual_mm"]]) for shown in maps]
    largest = np.nanquantile(np.abs(values[0]), 0.995)
    for panel, rung, shown, residuals in zip(panels, rungs, maps, values):
        mesh = panel.pcolormesh(1e3 * np.array(shown["time_s"]), shown["height_mm"], residuals.T,
                                cmap="RdBu_r", vmin=-largest, vmax=largest, shading="nearest",
                                rasterized=True)
        panel.set(ylabel="height, mm")
        panel.set_title(f"{literal(name_of(rung))}: {number(rung['rmse_mm'], 3)} mm rms", loc="left")
    panels[-1].set(xlabel="time, ms")
    bar = figure.colorbar(mesh, ax=list(panels), label="measured \N{MINUS SIGN} modelled, mm",
                          aspect=30, pad=0.02)
    bar.outline.set_linewidth(0.6)
    return figure


@styled
def spectrum_figure(comparison: Comparison):
    """Spectra of the residuals, with the modes of the fitted chain."""
    figure = new_figure(2.6, comparison.measurement)
    axes = figure.subplots()
    for rung, colour in first_and_last(comparison):
        spectrum = rung["where"]["spectrum"]
        axes.semilogy(spectrum["frequency_hz"], numbers(spectrum["power_over_noise"]),
                      color=colour, linewidth=0.8, label=literal(name_of(rung)))
    for place, frequency in enumerate(comparison.rungs[-1]["where"]["spectrum"]
                                      ["mode_frequencies_hz"], 1):
        axes.axvline(frequency, color=GREY, linewidth=0.8, zorder=0)
        axes.annotate(f"mode {place}", (frequency, 1.01), xycoords=("data", "axes fraction"),
                      va="bottom", ha="center", fontsize=7)
    axes.axhline(1.0, color=BLACK, linewidth=0.6, linestyle=":")
    axes.set(xlabel="frequency, Hz", ylabel="power of the residuals / noise")
    axes.legend()
    return figure


@styled
def amplitude_figure(comparison: Comparison):
    """The backbone of mode 1, measured and modelled."""
    measured = comparison.rungs[-1]["where"]["backbone"]["measured"]
    if not points_of(measured):
        raise FigureSkipped("the record is too short for windows of eight cycles.")
    figure = new_figure(2.8, comparison.measurement)
    panels = figure.subplots(1, 2)
    for panel, letter, (key, error, label) in zip(panels, "ab", QUANTITIES):
        draw_points(panel, points_of(measured), key, error, fmt="o", markersize=3, color=BLACK,
                    elinewidth=0.6, label="measured")
        for rung, colour in first_and_last(comparison):
            draw_points(panel, points_of(rung["where"]["backbone"]["modelled"]), key, None,
                        fmt="-", color=colour, label=literal(name_of(rung)))
        panel.set_xscale("log")
        panel.set(xlabel=amplitude_label(measured[0]), ylabel=label)
        mark(panel, letter)
    leave_room_above(panels[1], 0.3)
    panels[1].legend(loc="upper left")
    return figure


@styled
def heights_figure(comparison: Comparison):
    """Residuals and b1 per cycle along the stem."""
    figure = new_figure(2.8, comparison.measurement)
    residual, decay = figure.subplots(1, 2, sharey=True)
    for rung, colour in first_and_last(comparison):
        where = rung["where"]
        heights = [group["height_mm"] for group in where["by_height"]]
        residual.plot(numbers([group["rms_over_noise"] for group in where["by_height"]]), heights,
                      "o-", color=colour, markersize=3, label=literal(name_of(rung)))
        known = [height for height in where["banding"]["heights"] if height["modelled"]]
        decay.plot([height["modelled"]["value"] for height in known],
                   [height["height_mm"] for height in known], "-", color=colour)
    known = [height for height in comparison.rungs[-1]["where"]["banding"]["heights"]
             if height["measured"]]
    decay.errorbar([height["measured"]["value"] for height in known],
                   [height["height_mm"] for height in known],
                   xerr=[1.96 * height["measured"]["stderr"] for height in known], fmt="o",
                   markersize=3, color=BLACK, elinewidth=0.6)
    residual.axvline(1.0, color=GREY, linewidth=0.8, zorder=0)
    residual.set(xlabel="residual / noise", ylabel="height, mm")
    decay.set(xlabel="b1 per cycle (points: measured)")
    for panel, letter in zip((residual, decay), "ab"):
        mark(panel, letter)
    residual.legend()
    return figure


FIGURES = {
    "ladder": ladder_figure,
    "residuals": residuals_figure,
    "spectrum": spectrum_figure,
    "amplitude": amplitude_figure,
    "heights": heights_figure,
}


def parse(arguments):
    parser = OneSentenceParser(prog="compare_figures.py", description="Where and how models fail.")
    parser.add_argument("path", metavar="FILE_OR_DIR", type=Path,
                        help="output of culm compare --json or -o")
    add_output_options(parser, "the folder of the file")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)

    def draw():
        comparison = Comparison(options.path)
        write_figures("compare_figures.py", FIGURES, comparison,
                      options.out or comparison.file.parent, options.format)

    return exit_code_of("compare_figures.py", (ComparisonError,), draw)


if __name__ == "__main__":
    sys.exit(main())
