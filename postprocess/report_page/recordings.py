# SPDX-License-Identifier: BSD-3-Clause
"""The recordings of a laboratory's specimens: their folders, and a small drawing of each motion.

A laboratory.json names folders anywhere on the machine. A file there is read only if its size and
CRC-32 are those in the provenance: the page shows what was diagnosed, and a document made by others
cannot put other files of the machine into it.
"""
from __future__ import annotations

import csv
import os
import tomllib
import zlib
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import numpy as np

from palette import BLUE, GREY
from report_page.markup import Markup, escaped, shown

WIDTH, HEIGHT = 130, 26  # pixels of a small drawing
MOST_SAMPLES = 2 * WIDTH
MM_PER_UNIT = {"mm": 1.0, "m": 1e3}


@dataclass
class Recording:
    """A recording of a specimen; the arrays are empty if it could not be read."""

    specimen: str
    folder: Path | None  # None if it is not on this machine
    height_mm: float
    time_s: np.ndarray
    deflection_mm: np.ndarray  # at the highest row; NaN where nothing was seen


def read_recordings(content: dict, document: Path) -> list[Recording]:
    """One for each member of "folders". A relative folder is sought from the working directory, the
    folder of the document and those above it."""
    provenance = content.get("provenance") or {}
    inputs = {Path(entry["file"]): entry for entry in provenance.get("inputs", [])}
    places = [Path(), *document.resolve().parents]
    return [_read(Path(folder), inputs, places) for folder in content["folders"]]


def _read(stated: Path, inputs: dict, places: list[Path]) -> Recording:
    folder = next((place / stated for place in places if (place / stated).is_dir()), None)
    recording = Recording(stated.name, folder, np.nan, np.empty(0), np.empty(0))
    if folder is None:
        return recording
    try:
        stem = tomllib.loads(_unchanged(folder, stated, "stem.toml", inputs))["stem"]
        recording.specimen = str(stem.get("specimen") or stem["id"])
        lines = _unchanged(folder, stated, "deflection.csv", inputs).splitlines()
        recording.height_mm, recording.time_s, recording.deflection_mm = _highest_row(lines)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError):
        pass  # the recording has no drawing
    return recording


def _unchanged(folder: Path, stated: Path, name: str, inputs: dict) -> str:
    """The text of the file if it is the one that was diagnosed; else a ValueError."""
    file, entry = folder / name, inputs[stated / name]
    if entry["bytes"] is None or file.stat().st_size != entry["bytes"]:
        raise ValueError(f"{file} has changed")
    content = file.read_bytes()
    if f"{zlib.crc32(content):08x}" != entry["crc32"]:
        raise ValueError(f"{file} has changed")
    return content.decode("utf-8-sig")


def _highest_row(lines: list[str]) -> tuple[float, np.ndarray, np.ndarray]:
    """Height in mm, times in s and deflections in mm; columns of sensors are ignored."""
    names, *rows = csv.reader(line for line in lines if line and not line.startswith("#"))
    heights = {}
    for column, name in enumerate(names):
        text = name.strip().removeprefix("h=")
        unit = "mm" if text.endswith("mm") else "m"
        if text != name.strip() and text.endswith(unit):
            heights[column] = MM_PER_UNIT[unit] * float(text.removesuffix(unit)), unit
    column = max(heights, key=lambda each: heights[each][0])
    height, unit = heights[column]
    values = [[float(row[place].strip() or "nan") for place in (0, column)]
              for row in rows if any(row)]
    time, deflection = np.array(values, dtype=float).T
    return height, time, MM_PER_UNIT[unit] * deflection


def scale_of(recordings: list[Recording]) -> tuple[float, float, float]:
    """First and last time, s, and largest deflection, mm, of all that were read."""
    read = [each for each in recordings if np.isfinite(each.deflection_mm).any()]
    if not read:
        return 0.0, 0.0, 0.0
    return (min(float(each.time_s[0]) for each in read),
            max(float(each.time_s[-1]) for each in read),
            max(float(np.nanmax(np.abs(each.deflection_mm))) for each in read))


def sparkline(recording: Recording, scale: tuple[float, float, float]) -> Markup:
    """The deflection over time as a small drawing; "–" if it could not be read."""
    start, end, largest = scale
    if not np.isfinite(recording.deflection_mm).any() or end <= start or largest <= 0.0:
        return Markup("–")
    time, values = _envelope(recording.time_s, recording.deflection_mm)
    across = (time - start) / (end - start) * (WIDTH - 2) + 1
    down = 0.5 * HEIGHT - values / largest * (0.5 * HEIGHT - 1.5)
    path, pen = [], "M"
    for x, y in zip(across, down):
        if np.isfinite(y):
            path.append(f"{pen}{x:.1f} {y:.1f}")
        pen = "L" if np.isfinite(y) else "M"
    words = (f"{recording.specimen}: deflection at {shown(recording.height_mm)} mm over "
             f"{shown(1e3 * float(recording.time_s[-1] - recording.time_s[0]), 3)} ms, at most "
             f"{shown(float(np.nanmax(np.abs(recording.deflection_mm))), 3)} mm")
    return Markup(
        f"<svg class=\"sparkline\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} "
        f"{HEIGHT}\" role=\"img\" aria-label=\"{escaped(words)}\"><title>{escaped(words)}</title>"
        f"<path d=\"M0 {HEIGHT / 2}H{WIDTH}\" stroke=\"{GREY}\"/><path d=\"{''.join(path)}\" "
        f"fill=\"none\" stroke=\"{BLUE}\"/></svg>")


def _envelope(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All samples, or of each group of frames the smallest and the largest."""
    if time.size <= MOST_SAMPLES:
        return time, values
    groups = np.array_split(np.arange(time.size), MOST_SAMPLES // 2)
    ends = []
    for group in groups:
        seen = values[group][np.isfinite(values[group])]
        ends += [seen.min(), seen.max()] if seen.size else [np.nan, np.nan]
    return np.repeat([time[group[0]] for group in groups], 2), np.array(ends)


def link_to(recording: Recording, text: str, page_folder: Path) -> Markup:
    """A link from the page to the folder, relative, so that both can be moved together."""
    if recording.folder is None:
        return Markup(escaped(text))
    way = os.path.relpath(recording.folder.resolve(), page_folder.resolve())
    return Markup(f"<a href=\"{escaped(quote(Path(way).as_posix()))}/\">{escaped(text)}</a>")
