#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the figures of a study from its result folder: figures.py DIR [-o OUT] [--format png,pdf].

Writes regression, residuals, tip_history and design (of a time-step study: timestep) to OUT
(default: DIR) and prints each path.
Exit codes: 0 done, 2 bad input. In a notebook call the functions; each returns a matplotlib Figure:

    from culm_archive import Study
    import figures
    with Study("results/schramm2019") as study:
        figures.regression_figure(study)
"""
from __future__ import annotations

import sys
from pathlib import Path

from culm_archive import Study, StudyError
from design_figure import design_figure
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figures
from regression_figures import regression_figure, residual_figure
from timestep_figure import is_timestep_study, timestep_figure
from tip_history_figure import tip_history_figure

FIGURES = {
    "regression": regression_figure,
    "residuals": residual_figure,
    "tip_history": tip_history_figure,
    "design": design_figure,
}
TIMESTEP_FIGURES = {"timestep": timestep_figure}


def parse(arguments):
    parser = OneSentenceParser(prog="figures.py", description="Figures of a study.")
    parser.add_argument("directory", metavar="DIR", type=Path, help="result folder of a study")
    add_output_options(parser, "DIR")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)

    def draw():
        with Study(options.directory) as study:
            drawn = TIMESTEP_FIGURES if is_timestep_study(study) else FIGURES
            write_figures("figures.py", drawn, study, options.out or study.directory,
                          options.format)

    return exit_code_of("figures.py", (StudyError,), draw)


if __name__ == "__main__":
    sys.exit(main())
