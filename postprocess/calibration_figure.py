#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws measured and fitted motion from a folder of `culm calibrate -o DIR`:
calibration_figure.py DIR [--stem N] [-o OUT].

Of the N-th stem (from 1) the row that moves most, and what the chain leaves of it; to OUT (default:
DIR). Prints the path. Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figure
from figure_style import BLUE, GREY, VERMILLION, FigureSkipped, new_figure, number, styled


class CalibrationError(Exception):
    """The folder does not hold what culm calibrate -o writes."""


class CalibrationResults:
    """calibration.json and the predictions beside it."""

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            document = json.loads((folder / "calibration.json").read_text("utf-8"))
        except (OSError, ValueError) as error:
            raise CalibrationError(f"{folder / 'calibration.json'} cannot be read: {error}") from None
        if document.get("format") != "culm-calibration":
            raise CalibrationError(f"{folder / 'calibration.json'} is not a calibration.")
        self.stems = document["stems"]

    def prediction(self, stem_number: int):
        """Times in s; heights in mm; measured and predicted deflection (frames, heights) in mm."""
        file = self.folder / "predictions" / f"{stem_number:03}.csv"
        try:
            with file.open(encoding="utf-8") as lines:
                names, *rows = csv.reader(lines)
        except (OSError, ValueError) as error:
            raise CalibrationError(f"{file} cannot be read: {error}") from None
        table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
        heights = [float(name.split("h=")[1][:-2]) for name in names[1::2]]
        return table[:, 0], heights, table[:, 1::2], table[:, 2::2]


def stem_of(results: CalibrationResults, stem_number: int) -> dict:
    if not 1 <= stem_number <= len(results.stems):
        raise CalibrationError(f"stem {stem_number}: there are {len(results.stems)}.")
    stem = results.stems[stem_number - 1]
    if "failure" in stem:
        raise FigureSkipped(f"{stem['measurement']} was not calibrated: {stem['failure']}")
    return stem


@styled
def motion_figure(results: CalibrationResults, stem_number: int = 1):
    """Above the motion, below what is left of it with the noise as a band."""
    stem = stem_of(results, stem_number)
    times, heights, measured, predicted = results.prediction(stem_number)
    row = int(np.nanargmax(np.nanmax(np.abs(measured), axis=0)))
    title = (f"{stem['measurement']}, h = {heights[row]:g} mm: "
             f"{number(stem['fit']['rmse_mm'], 3)} mm rms left, "
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
    lower.set(xlabel="time after the release, s", ylabel="measured − fitted, mm")
    return figure


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
