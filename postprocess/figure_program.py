# SPDX-License-Identifier: BSD-3-Clause
"""Options, output files and error messages shared by the programs that draw figures."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from figure_style import FigureSkipped, save

FORMATS = ("png", "pdf", "svg")
EXIT_BAD_INPUT = 2


class OneSentenceParser(argparse.ArgumentParser):
    """Reports an error in one sentence, without the usage."""

    def error(self, message):
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {message} (see --help).\n")


def formats_of(text: str) -> list[str]:
    names = list(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in names:
        if name not in FORMATS:
            raise argparse.ArgumentTypeError(f"'{name}' is not one of {', '.join(FORMATS)}")
    return names


def add_output_options(parser: argparse.ArgumentParser, default_folder: str):
    parser.add_argument("-o", "--out", metavar="OUT", type=Path,
                        help=f"folder to write to ({default_folder})")
    parser.add_argument("--format", metavar="LIST", type=formats_of, default=["png"],
                        help="png,pdf,svg (png)")


def write_figure(figure, folder: Path, name: str, formats: list[str]):
    """Writes the figure in every format, and prints the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    for suffix in formats:
        path = folder / f"{name}.{suffix}"
        save(figure, path)
        print(path, flush=True)


def write_figures(program: str, figures: dict, data, folder: Path, formats: list[str]):
    """Draws every figure for which there are data; skipped figures are named on standard error."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make_figure in figures.items():
        try:
            figure = make_figure(data)
        except FigureSkipped as reason:
            print(f"{program}: {name} is left out: {reason}", file=sys.stderr)
            continue
        write_figure(figure, folder, name, formats)


def exit_code_of(program: str, refusals: tuple[type[Exception], ...], action) -> int:
    """Calls `action`; reports a refusal or an unusable file in one sentence on standard error."""
    try:
        action()
    except refusals as error:
        print(f"{program}: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"{program}: {error.filename}: {error.strerror}.", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0
