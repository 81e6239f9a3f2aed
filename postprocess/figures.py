#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the figures of a result folder: figures.py DIR [-o OUT] [--format png,pdf,svg].

A study has regression (Eqs. 12 and 13), residuals (the paper's Fig. 8), tip_history (Fig. 7) and
design; a time-step study has timestep; a tracked recording has displacements (Fig. 3a); measured
stems have histories (Fig. 3b and c), population (Fig. 5), banding (Fig. 6) and backbone (frequency
and damping against amplitude). Calibrations, comparisons and diagnoses have figures as well. The
name of a figure of measurements begins with its file (fit_population, comparison_ladder). Writes to
OUT (default: DIR) and prints each path. Exit codes: 0 done, 2 bad input. In a notebook call the
functions; each returns a matplotlib Figure:

    from culm.archive import Study
    import figures
    with Study("results/schramm2019") as study:
        figures.regression_figure(study)
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "h5py", "matplotlib")

import sys
from pathlib import Path

import calibration_figure
import compare_figures
import diagnose_figures
import fit_figures
from command_results import (CalibrationError, CalibrationResults, Comparison, ComparisonError,
                             Diagnosis, DiagnosisError, FitError, FitResults, TrackError,
                             TrackResults)
from culm.archive import Study, StudyError
from design_figure import design_figure
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figures
from regression_figures import regression_figure, residual_figure
from timestep_figure import timestep_figure
from timestep_results import is_timestep_study
from tip_history_figure import tip_history_figure

FIGURES = {
    "regression": regression_figure,
    "residuals": residual_figure,
    "tip_history": tip_history_figure,
    "design": design_figure,
}
TIMESTEP_FIGURES = {"timestep": timestep_figure}


# The results other than a study that a folder may contain: file, reader, figures.
DOCUMENTS = (
    ("track.json", TrackResults, lambda track: fit_figures.TRACK_FIGURES),
    ("fit.json", FitResults, lambda results: fit_figures.FIGURES),
    ("calibration.json", CalibrationResults, calibration_figure.figures_of),
    ("comparison.json", Comparison, lambda comparison: compare_figures.FIGURES),
    ("diagnosis.json", Diagnosis, lambda diagnosis: diagnose_figures.FIGURES),
)
REFUSALS = (StudyError, TrackError, FitError, CalibrationError, ComparisonError, DiagnosisError)


def parse(arguments):
    parser = OneSentenceParser(prog="figures.py", description="Figures of a result folder.")
    parser.add_argument("directory", metavar="DIR", type=Path, help="result folder")
    add_output_options(parser, "DIR")
    return parser.parse_args(arguments)


def draw_study(options):
    """Draws the figures of a study; raises StudyError if the folder contains none."""
    with Study(options.directory) as study:
        drawn = TIMESTEP_FIGURES if is_timestep_study(study) else FIGURES
        write_figures("figures.py", drawn, study, options.out or study.directory, options.format)


def draw(options):
    folder = options.directory
    documents = [entry for entry in DOCUMENTS if (folder / entry[0]).is_file()]
    if not documents or (folder / "study.h5").is_file():
        draw_study(options)
    for file, read, figures_of in documents:
        results = read(folder)
        named = {f"{Path(file).stem}_{name}": make for name, make in figures_of(results).items()}
        write_figures("figures.py", named, results, options.out or folder, options.format)


def main(arguments=None) -> int:
    options = parse(arguments)
    return exit_code_of("figures.py", REFUSALS, lambda: draw(options))


if __name__ == "__main__":
    sys.exit(main())
