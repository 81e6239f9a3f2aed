# SPDX-License-Identifier: BSD-3-Clause
"""The style of all figures: two-column width, the common colours (palette.py), one set of sizes."""
from __future__ import annotations

import functools

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

TWO_COLUMNS_INCH = 7.2  # 183 mm
MOST_TICKS = 10

STYLE = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 7,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "mathtext.fontset": "dejavusans",
    "savefig.dpi": 300,
    "pdf.fonttype": 42,  # TrueType, which journals ask for
    "svg.hashsalt": "culm",  # the same data give the same bytes
}


class FigureSkipped(Exception):
    """The study does not contain the data of a figure; one sentence."""


def styled(make_figure):
    """Decorator that draws a figure in the common style, whatever the caller's settings are."""

    @functools.wraps(make_figure)
    def in_style(*arguments, **options):
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(STYLE)
            return make_figure(*arguments, **options)

    return in_style


def new_figure(height_inch: float, heading: str) -> Figure:
    """A figure of two-column width, drawn by Agg without a display."""
    figure = Figure(figsize=(TWO_COLUMNS_INCH, height_inch), layout="constrained")
    FigureCanvasAgg(figure)
    figure.get_layout_engine().set(wspace=0.06)
    if heading:
        figure.suptitle(literal(heading), fontsize=7)
    return figure


def literal(text: str) -> str:
    """Text from a file, escaped so that a dollar sign does not begin a formula."""
    return text.replace("$", r"\$")


def mark(axes, letter: str):
    """The letter of a panel."""
    axes.set_title(f"({letter})", loc="left", fontweight="bold")


def leave_room_above(axes, share: float):
    """Extends the vertical axis so that its upper `share` is free for the legend."""
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, bottom + (top - bottom) / (1.0 - share))


def whole_numbers(axis):
    """Sets whole numbers as ticks of an axis that counts."""
    axis.set_major_locator(MaxNLocator(integer=True))


def colour_bar(figure, shown, axes, label: str, levels):
    """A slim colour bar, with a tick for each level if there are few."""
    bar = figure.colorbar(shown, ax=axes, label=label, aspect=30, pad=0.02)
    bar.outline.set_linewidth(0.6)
    levels = sorted(set(levels))
    if len(levels) <= MOST_TICKS:
        bar.set_ticks(levels)
    return bar


def save(figure, path):
    """Writes a figure; the format is the path's suffix. The same data give the same bytes."""
    undated = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        figure.savefig(path, metadata=undated.get(path.suffix))
