#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws measured and fitted motion from a folder of `culm calibrate -o DIR`:
calibration_figure.py DIR [--stem N] [-o OUT].

Draws the row of the N-th stem (from 1) that moves most, and its residual. Writes to OUT (default:
DIR) and prints the path. Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "h5py", "matplotlib")

import functools
import sys
from pathlib import Path

import numpy as np
from command_results import CalibrationError, CalibrationResults
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figure
from figure_style import FigureSkipped, mark, new_figure, styled, whole_numbers
from palette import BLUE, GREY, VERMILLION, number


def stem_of(results: CalibrationResults, stem_number: int) -> dict:
    if not 1 <= stem_number <= len(results.stems):
        raise CalibrationError(f"stem {stem_number}: there are {len(results.stems)}.")
    stem = results.stems[stem_number - 1]
    if "failure" in stem:
        raise FigureSkipped(f"{stem['measurement']} was not calibrated: {stem['failure']}")
    return stem


@styled
def motion_figure(results: CalibrationResults, stem_number: int = 1):
    """The upper panel shows the motion, the lower one the residual (measured − fitted) with a band
    of ± two standard deviations of the noise."""
    stem = stem_of(results, stem_number)
    times, heights, measured, predicted = results.prediction(stem_number)
    row = int(np.nanargmax(np.nanmax(np.abs(measured), axis=0)))
    title = (f"{stem['measurement']}, h = {heights[row]:g} mm: "
             f"{number(stem['fit']['rmse_mm'], 3)} mm rms residual, "
             f"noise {number(stem['fit']['noise_mm'], 3)} mm")
    figure = new_figure(3.4, title)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    upper.plot(times, measured[:, row], ".", color=BLUE, markersize=2.5, label="measured")
    upper.plot(times, predicted[:, row], color=VERMILLION, linewidth=0.8, label="fitted chain")
    upper.set(ylabel="deflection, mm")
    upper.legend(loc="upper right")
    noise = stem["fit"]["noise_mm"]
    lower.axhspan(-2 * noise, 2 * noise, color=GREY, alpha=0.3, linewidth=0)
    lower.plot(times, measured[:, row] - predicted[:, row], ".", color=BLUE, markersize=2.5)
    lower.set(xlabel="time after the release, s", ylabel="residual, mm")
    figure.align_ylabels()
    return figure


@styled
def population_figure(results: CalibrationResults):
    """Histograms of Y and beta of all calibrated stems; 90 % lie between the dashed lines."""
    population = results.content.get("population")
    if not population:
        raise FigureSkipped("a population needs more than one stem.")
    stems = [stem["parameters"] for stem in results.stems if "failure" not in stem]
    figure = new_figure(2.6, f"{len(stems)} stems")
    panels = figure.subplots(1, 2)
    keys = [("bond_youngs_modulus_pa", "bond Young's modulus, GPa", 1e-9),
            ("bond_damping", "bond damping", 1.0)]
    for axes, letter, (key, label, factor) in zip(panels, "ab", keys):
        values = factor * np.array([stem[key]["value"] for stem in stems], dtype=float)
        counts, edges = np.histogram(values, bins="auto")
        axes.stairs(counts, edges, fill=True, color=BLUE, alpha=0.75)
        for end in population[key]["central_90_percent"]:
            axes.axvline(factor * end, color=VERMILLION, linewidth=0.8, linestyle="--")
        axes.set(xlabel=label, ylabel="stems")
        whole_numbers(axes.yaxis)
        mark(axes, letter)
    return figure


def figures_of(results: CalibrationResults) -> dict:
    """The functions that draw all figures of these results, by the names of their files."""
    motions = {f"motion-{number:03}": functools.partial(motion_figure, stem_number=number)
               for number in range(1, len(results.stems) + 1)}
    return {"population": population_figure, **motions}


def parse(arguments):
    parser = OneSentenceParser(prog="calibration_figure.py",
                               description="Measured and fitted motion of a calibrated stem.")
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder of culm calibrate -o")
    parser.add_argument("--stem", metavar="N", type=int, default=1, help="which stem, from 1 (1)")
    add_output_options(parser, "DIR")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)

    def draw():
        figure = motion_figure(CalibrationResults(options.directory), options.stem)
        write_figure(figure, options.out or options.directory, f"motion-{options.stem:03}",
                     options.format)

    return exit_code_of("calibration_figure.py", (CalibrationError, FigureSkipped), draw)


if __name__ == "__main__":
    sys.exit(main())
