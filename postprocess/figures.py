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

import argparse
import sys
from pathlib import Path

from culm_archive import Study, StudyError
from design_figure import design_figure
from figure_style import FigureSkipped, save
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
FORMATS = ("png", "pdf", "svg")
EXIT_BAD_INPUT = 2


class OneSentenceParser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, without the usage."""

    def error(self, message):
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {message} (see --help).\n")


def formats_of(text: str) -> list[str]:
    names = list(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in names:
        if name not in FORMATS:
            raise argparse.ArgumentTypeError(f"'{name}' is not one of {', '.join(FORMATS)}")
    return names


def parse(arguments):
    parser = OneSentenceParser(prog="figures.py", description="Figures of a study.")
    parser.add_argument("directory", metavar="DIR", type=Path, help="result folder of a study")
    parser.add_argument("-o", "--out", metavar="OUT", type=Path, help="folder to write to (DIR)")
    parser.add_argument(
        "--format", metavar="LIST", type=formats_of, default=["png"], help="png,pdf,svg (png)"
    )
    return parser.parse_args(arguments)


def write_figures(study: Study, folder: Path, formats: list[str]):
    """Draws every figure that the study has the data for; prints the paths, and what was skipped
    to the standard error."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = TIMESTEP_FIGURES if is_timestep_study(study) else FIGURES
    for name, make_figure in drawn.items():
        try:
            figure = make_figure(study)
        except FigureSkipped as reason:
            print(f"figures.py: {name} is left out: {reason}", file=sys.stderr)
            continue
        for suffix in formats:
            path = folder / f"{name}.{suffix}"
            save(figure, path)
            print(path, flush=True)


def main(arguments=None) -> int:
    options = parse(arguments)
    try:
        with Study(options.directory) as study:
            write_figures(study, options.out or study.directory, options.format)
    except StudyError as error:
        print(f"figures.py: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"figures.py: {error.filename}: {error.strerror}.", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
