# SPDX-License-Identifier: BSD-3-Clause
"""Traces and layouts for figures.js, in the common colours.

A trace is a dictionary: `type` ("scatter", "bar", "heatmap"), `x`, `y` (of a map also `z`), `name`,
`mode` ("lines", "markers", "text", joined by "+"), `line`, `marker`, `error_x`, `error_y`, `text`,
and `hoverinfo`: the members that a reader sees under the pointer.
"""
from __future__ import annotations

import numpy as np

from palette import BLUE, GREY, number

MOST_COLUMNS = 700  # of a map over time
MOST_MARKERS = 1000  # of a cloud of points
FEWEST_TICKS, MOST_TICKS = 3, 9  # of a logarithmic axis
DIVERGING = [[0.0, "#2166ac"], [0.25, "#92c5de"], [0.5, "#f7f7f7"], [0.75, "#f4a582"],
             [1.0, "#b2182b"]]  # ColorBrewer's RdBu, safe for colour-blind readers
# Stops of matplotlib's viridis.
SEQUENTIAL = [[k / 8, colour] for k, colour in enumerate((
    "#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30",
    "#fde725"))]


def axis(title: str = "", **options) -> dict:
    """`type` "log" or "category", `range` (of logarithms on a logarithmic axis), `rangemode`
    "tozero", `autorange` "reversed", `whole` numbers only, a dark line at zero by `zeroline`."""
    return {"title": title, **options}


def log_axis(title: str, values, **options) -> dict:
    """Logarithmic over `values`, with ticks at 1, 2, 5 of every decade, at more where these are few
    and at whole decades where they are many."""
    known = np.asarray([value for value in values if value and value > 0.0], dtype=float)
    if not known.size:
        return axis(title, type="log", **options)
    low, high = np.log10(known.min()), np.log10(known.max())
    margin = 0.06 * max(high - low, 0.5)
    ends = [low - margin, high + margin]
    decades = 10.0 ** np.arange(np.floor(ends[0]), np.ceil(ends[1]) + 1)
    for mantissas in ((1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)):
        ticks = (decades[:, None] * np.array(mantissas)).ravel()
        ticks = ticks[(np.log10(ticks) >= ends[0]) & (np.log10(ticks) <= ends[1])]
        if ticks.size >= FEWEST_TICKS:
            break
    if ticks.size > MOST_TICKS:
        ticks = decades[:: 1 + decades.size // MOST_TICKS]
    return axis(title, **{"type": "log", "range": ends, "tickvals": ticks,
                          "ticktext": [number(tick) for tick in ticks], **options})


def layout(x: dict, y: dict, legend: bool = True, **options) -> dict:
    """Two axes; `levels` are lines across the drawing, `yaxis2` a second panel over the same x."""
    return {"xaxis": x, "yaxis": y, "showlegend": legend, **options}


def line(x, y, name: str, colour: str, dash: str = "solid", width: float = 1.6, **options) -> dict:
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "name": name,
            "line": {"color": colour, "dash": dash, "width": width}, **options}


def dots(x, y, name: str, colour="#0072B2", size: float = 6, symbol: str = "circle",
         **options) -> dict:
    return {"type": "scatter", "mode": "markers", "x": x, "y": y, "name": name,
            "marker": {"color": colour, "size": size, "symbol": symbol}, **options}


def level(value: float, colour: str = GREY, dash: str = "solid", along: str = "y") -> dict:
    """A line across the whole drawing at a value of its vertical axis ("y") or horizontal ("x")."""
    return {"at": value, "colour": colour, "dash": dash, "along": along}


def heat_map(x, y, z, title: str, diverging_at: float | None = None) -> dict:
    """Cells; with `diverging_at` from minus to plus that value about a neutral middle."""
    trace = {"type": "heatmap", "x": x, "y": y, "z": z, "colorbar": title,
             "colorscale": SEQUENTIAL, "hoverinfo": "x+y+z"}
    if diverging_at is not None:
        trace |= {"colorscale": DIVERGING, "zmin": -diverging_at, "zmax": diverging_at}
    return trace


def bars(counts, edges, name: str = "", colour: str = BLUE) -> dict:
    """A histogram from its counts (n) and edges (n + 1)."""
    edges = np.asarray(edges, dtype=float)
    texts = [f"{number(a)} … {number(b)}: {c}" for a, b, c in zip(edges, edges[1:], counts)]
    return {"type": "bar", "x": 0.5 * (edges[1:] + edges[:-1]), "y": counts, "name": name,
            "width": np.diff(edges), "text": texts, "hoverinfo": "text",
            "marker": {"color": colour}}


def outline(counts, edges, name: str, colour: str) -> dict:
    """A histogram as a line of steps."""
    return {"type": "scatter", "mode": "lines", "x": edges, "y": [*counts, 0], "name": name,
            "line": {"shape": "hv", "color": colour, "width": 1.6}, "hoverinfo": "x+y"}


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Times (T), values (T, H) with at most MOST_COLUMNS times, and how many frames one stands for.
    Of each group of frames the value of the largest magnitude stays, at the group's first time."""
    group = -(-time.size // MOST_COLUMNS)
    if group == 1:
        return time, values, 1
    missing = -time.size % group
    padded = np.vstack([values, np.full((missing, values.shape[1]), np.nan)])
    blocks = padded.reshape(-1, group, values.shape[1])
    largest = np.argmax(np.where(np.isfinite(blocks), np.abs(blocks), -1.0), axis=1)
    kept = np.take_along_axis(blocks, largest[:, None, :], axis=1)[:, 0, :]
    return time[::group], kept, group


def chosen_rows(importance: np.ndarray, most: int = MOST_MARKERS) -> np.ndarray:
    """At most `most` rows, rising: every row if they are few, else half of them evenly spaced and
    the others those of the largest importance, so that no outlier is lost; all evenly spaced where
    every row is as important."""
    count = importance.size
    if count <= most:
        return np.arange(count)
    weight = np.nan_to_num(importance)
    evenly = most if np.ptp(weight) == 0.0 else most // 2
    even = np.linspace(0, count - 1, evenly).round().astype(int)
    weight[even] = -np.inf
    largest = np.argsort(-weight, kind="stable")[:most - evenly]
    return np.union1d(even, largest)
