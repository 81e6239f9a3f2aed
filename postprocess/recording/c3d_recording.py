# SPDX-License-Identifier: BSD-3-Clause
"""Reads the markers of a C3D file of optical motion capture ("The C3D File Format", Motion Lab
Systems, 2008): Intel numbers, points as floats or scaled integers. Analog samples are skipped."""
from __future__ import annotations

import math
import struct
import sys
from array import array
from dataclasses import dataclass
from pathlib import Path

from recording.c3d_parameters import (BLOCK, Content, Parameter, Parameters, parameters_at, plain, printable,
                            refusal, stated)
from recording.refusal import Table

LARGEST_FILE = 1 << 30
MOST_FRAMES = 1e9
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


@dataclass
class Layout:
    """Position and coding of the points."""
    begin: int
    markers: int
    analog_words: int  # per frame, after the points
    frames: int
    scale: float  # negative: coordinates are floats

    def code(self) -> str:
        return "f" if self.scale < 0.0 else "h"

    def frame_words(self) -> int:
        return 4 * self.markers + self.analog_words

    def end(self) -> int:
        return self.begin + self.frames * self.frame_words() * struct.calcsize("<" + self.code())


def whole(named: tuple[str, float], lowest: int, highest: float) -> int:
    key, value = named
    if not lowest <= value <= highest or value != math.floor(value):
        raise refusal(f"{key} = {plain(value)}: must be a whole number from {lowest} to "
                      f"{highest:.0f}")
    return int(value)


def frame_count(content: Content, parameters: Parameters) -> tuple[str, float]:
    """The header counts frames in 16 bits; longer recordings use one of several parameters."""
    first, last = content.word(6), content.word(8)
    frames = ("the header's last - first frame + 1", float(max(0, last - first + 1)))
    count = stated(parameters, "POINT:FRAMES", "", 0.0)
    if count[1] > frames[1]:
        frames = count
    count = stated(parameters, "POINT:LONG_FRAMES", "", 0.0)
    if count[1] > 0.0:
        frames = count
    # These contain 32 bits in two words, low word first.
    begin, end = (parameters.get(b"TRIAL:ACTUAL_%s_FIELD" % name, Parameter()).numbers
                  for name in (b"START", b"END"))
    if last == 65535 and len(begin) == len(end) == 2:
        actual = end[0] - begin[0] + 65536.0 * (end[1] - begin[1]) + 1.0
        if actual >= 1.0:
            frames = ("TRIAL:ACTUAL_END_FIELD - ACTUAL_START_FIELD + 1", actual)
    return frames


def layout_of(content: Content, parameters: Parameters) -> Layout:
    used = stated(parameters, "POINT:USED", "the header's number of markers", content.word(2))
    start = stated(parameters, "POINT:DATA_START", "the header's first data block",
                   content.word(16))
    scale = stated(parameters, "POINT:SCALE", "the header's scale", content.number("<f", 12))
    frames = frame_count(content, parameters)
    if not math.isfinite(scale[1]):
        raise refusal(f"{scale[0]} = {scale[1]}: must be a number")
    if used[1] == 0.0 or frames[1] == 0.0:
        raise refusal("it holds no markers")
    markers = whole(used, 1, 65535)  # the format counts markers in 16 bits
    count = whole(frames, 1, MOST_FRAMES)
    begin = (whole(start, 2, LARGEST_FILE // BLOCK) - 1) * BLOCK
    layout = Layout(begin, markers, content.word(4), count, scale[1])
    if len(content) < layout.end():
        raise refusal(f"{count} frames of {markers} markers need {layout.end()} bytes, the file "
                      f"has {len(content)}")
    return layout


def labels_of(parameters: Parameters, markers: int) -> list[str]:
    """Different names; a marker whose label is empty or repeated is called by its number."""
    texts = [text for name in (b"POINT:LABELS", b"POINT:LABELS2", b"POINT:LABELS3")
             for text in parameters.get(name, Parameter()).texts]
    labels: dict[str, None] = {}
    for k in range(markers):
        label = printable(texts[k]) if k < len(texts) else ""
        labels[f"marker {k + 1}" if not label or label in labels else label] = None
    if len(labels) < markers:
        raise refusal("POINT:LABELS repeats a label and calls another marker by its number; the "
                      "labels must differ")
    return list(labels)


def columns_of(content: Content, layout: Layout, labels: list[str], metres: float) -> Table:
    words = array(layout.code())
    words.frombytes(memoryview(content.content)[layout.begin:layout.end()])
    if sys.byteorder == "big":
        words.byteswap()
    scale, step = 1.0 if layout.scale < 0.0 else layout.scale, layout.frame_words()
    table: Table = []
    for k, label in enumerate(labels):
        residuals = words[4 * k + 3::step]  # negative for a point that was not seen
        for axis, name in enumerate("xyz"):
            table.append((f"{label} {name}", array("d", (
                metres * (scale * value) if residual >= 0 else math.nan
                for value, residual in zip(words[4 * k + axis::step], residuals)))))
    return table


def content_of(source: Path) -> Content:
    """Reads block by block, because a device or a pipe has no size that can be checked before."""
    with source.open("rb") as stream:
        content = bytearray(stream.read(BLOCK))
        if len(content) < BLOCK or content[1] != 0x50 or content[0] < 2:
            raise refusal("its first two bytes are not those of a C3D file")
        while part := stream.read(1 << 20):
            content += part
            if len(content) > LARGEST_FILE:
                raise refusal(f"it is larger than {LARGEST_FILE >> 20} MiB")
    return Content(content)


def c3d_table(source: Path) -> Table:
    """The time in s from the first frame, and the coordinates of each marker in m."""
    content = content_of(source)
    parameters = parameters_at(content, (content.byte(0) - 1) * BLOCK)
    layout = layout_of(content, parameters)
    rate = stated(parameters, "POINT:RATE", "the header's frame rate", content.number("<f", 20))
    if not 0.0 < rate[1] < math.inf:
        raise refusal(f"{rate[0]} = {plain(rate[1])}: must be the number of frames per second, "
                      "above 0")
    units = parameters.get(b"POINT:UNITS", Parameter()).texts
    unit = printable(units[0]) if units else ""
    if unit not in METRES:
        raise refusal(f'POINT:UNITS = "{unit}": must be mm, cm or m')
    times = array("d", (frame / rate[1] for frame in range(layout.frames)))
    labels = labels_of(parameters, layout.markers)
    return [("t", times), *columns_of(content, layout, labels, METRES[unit])]
