#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws a diagnosis: diagnose_figures.py FILE_OR_DIR [-o OUT].

FILE was written by `culm diagnose --json`, DIR by `culm diagnose -o`. Writes error_ladder,
explanations, blind_spots and missing_force (if one was reconstructed) to OUT (default: the folder
of the file) and prints each path. Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "matplotlib")

import sys
from pathlib import Path

import numpy as np

from command_results import Diagnosis, DiagnosisError
from figure_program import OneSentenceParser, add_output_options, exit_code_of, write_figures
from figure_style import FigureSkipped, literal, mark, new_figure, styled
from palette import BLUE, GREY, VERMILLION, number
from matplotlib.ticker import FuncFormatter, NullFormatter


def plain_log_axis(axis):
    """Writes ticks as 0.04 rather than as powers of ten."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
    axis.set_minor_formatter(NullFormatter())


def with_plain_ticks(axes, smallest: float, largest: float):
    """Sets ticks at 1, 2 and 5 in every decade of a logarithmic horizontal axis."""
    decades = 10.0 ** np.arange(np.floor(np.log10(smallest)), np.ceil(np.log10(largest)) + 1)
    every = (decades[:, None] * np.array([1.0, 2.0, 5.0])).ravel()
    axes.set_xlim(smallest / 1.25, largest * 1.25)
    shown = [tick for tick in every if smallest / 1.25 <= tick <= largest * 1.25]
    axes.set_xticks(shown[::1 + len(shown) // 10])
    plain_log_axis(axes.xaxis)


@styled
def error_ladder_figure(diagnosis: Diagnosis):
    """The residual of every model on the way to the answer, with the noise as a line."""
    ladder = diagnosis.content["ladder"]
    figure = new_figure(1.1 + 0.35 * len(ladder), diagnosis.heading)
    axes = figure.subplots()
    places = np.arange(len(ladder))[::-1]
    errors = [rung["rmse_mm"] for rung in ladder]
    axes.plot(errors, places, "o-", color=BLUE, markersize=5)
    for error, place in zip(errors, places):
        axes.annotate(f"{number(error, 3)} mm", (error, place), xytext=(0, 6),
                      textcoords="offset points", ha="center", fontsize=7)
    noise = diagnosis.content["noise_mm"]
    axes.axvline(noise, color=GREY, linewidth=0.8, zorder=0)
    axes.annotate("noise", (noise, 0.03), xycoords=("data", "axes fraction"), rotation=90,
                  va="bottom", ha="right", fontsize=7)
    axes.set_xscale("log")
    with_plain_ticks(axes, min(errors + [noise]), max(errors + [noise]))
    axes.set_yticks(places, [literal(" +\n".join(rung["model"])) for rung in ladder])
    axes.set(xlabel="residual, mm (rms)", ylim=(-0.6, len(ladder) - 0.3))
    return figure


@styled
def explanations_figure(diagnosis: Diagnosis):
    """The probability of every set of effects that may explain the recording."""
    explanations = diagnosis.content["explanations"]
    if not explanations:
        raise FigureSkipped("no explanation has a probability.")
    figure = new_figure(0.9 + 0.25 * len(explanations), diagnosis.heading)
    axes = figure.subplots()
    places = np.arange(len(explanations))[::-1]
    axes.barh(places, [entry["probability"] for entry in explanations], 0.7, color=BLUE)
    axes.axvline(0.95, color=VERMILLION, linewidth=0.8, linestyle="--")
    axes.set_yticks(places, [literal(" with ".join(entry["effects"]) or "published chain")
                             for entry in explanations])
    axes.set(xlabel="probability (dashed: an answer needs 0.95)", xlim=(0.0, 1.0),
             ylim=(-0.6, len(explanations) - 0.4))
    return figure


def spot_label(spot: dict) -> str:
    size = spot["smallest_visible"]
    unit = f" {size['unit']}" if size["unit"] else ""
    return f"{literal(spot['effect'])} {number(size['value'], 2)}{unit}"


@styled
def blind_spots_figure(diagnosis: Diagnosis):
    """The bias of Y and beta by an effect at its detection limit."""
    spots = diagnosis.visible_spots
    if not spots:
        raise FigureSkipped("no effect has a detection limit.")
    spots = sorted(spots, key=lambda spot: abs(spot["bias"]["bond_youngs_modulus"] or 0.0) +
                   abs(spot["bias"]["bond_damping"] or 0.0))
    figure = new_figure(0.9 + 0.19 * len(spots), diagnosis.heading)
    panels = figure.subplots(1, 2, sharey=True)
    places = np.arange(len(spots))
    keys = [("bond_youngs_modulus", "bias of Y, %", BLUE), ("bond_damping", "bias of beta, %",
                                                           VERMILLION)]
    for panel, letter, (key, label, colour) in zip(panels, "ab", keys):
        panel.barh(places, [100.0 * (spot["bias"][key] or 0.0) for spot in spots], 0.7,
                   color=colour)
        panel.axvline(0.0, color="black", linewidth=0.6)
        panel.set(xlabel=label, ylim=(-0.6, len(spots) - 0.4))
        mark(panel, letter)
    panels[0].set_yticks(places, [spot_label(spot) for spot in spots])
    return figure


@styled
def missing_force_figure(diagnosis: Diagnosis):
    """The reconstructed force against displacement and velocity."""
    force = diagnosis.content["missing_force"]
    if not force or not force["form"]:
        raise FigureSkipped("no force was reconstructed.")
    is_moment = force["kind"] == "bending_moment"
    key = "moment_n_m" if is_moment else "force_n_per_m"
    figure = new_figure(2.6, f"{diagnosis.content['measurement']}: {force['form']}")
    panels = figure.subplots(1, 2, sharey=True)
    curves = [("against_displacement", "displacement_mm", "displacement of the tip, mm"),
              ("against_velocity", "velocity_m_s", "velocity of the tip, m/s")]
    for panel, letter, (curve, quantity, label) in zip(panels, "ab", curves):
        panel.plot([sample[quantity] for sample in force[curve]],
                   [sample[key] for sample in force[curve]], color=BLUE)
        panel.axhline(0.0, color=GREY, linewidth=0.6, zorder=0)
        panel.axvline(0.0, color=GREY, linewidth=0.6, zorder=0)
        panel.set(xlabel=label)
        mark(panel, letter)
    panels[0].set(ylabel="bending moment, N m" if is_moment else "force per length, N/m")
    return figure


FIGURES = {
    "error_ladder": error_ladder_figure,
    "explanations": explanations_figure,
    "blind_spots": blind_spots_figure,
    "missing_force": missing_force_figure,
}


def parse(arguments):
    parser = OneSentenceParser(prog="diagnose_figures.py", description="A diagnosis in figures.")
    parser.add_argument("path", metavar="FILE_OR_DIR", type=Path,
                        help="output of culm diagnose --json or -o")
    add_output_options(parser, "the folder of the file")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)

    def draw():
        diagnosis = Diagnosis(options.path)
        write_figures("diagnose_figures.py", FIGURES, diagnosis,
                      options.out or diagnosis.file.parent, options.format)

    return exit_code_of("diagnose_figures.py", (DiagnosisError,), draw)


if __name__ == "__main__":
    sys.exit(main())
