# SPDX-License-Identifier: BSD-3-Clause
"""Writes small C3D files, so that the tests of the reader need no recording."""
from __future__ import annotations

import struct
from dataclasses import dataclass, field


def word(value: int) -> bytes:
    return struct.pack("<H", value)


def real(value: float) -> bytes:
    return struct.pack("<f", value)


def padded(content: bytes) -> bytes:
    return content.ljust((len(content) + 511) // 512 * 512, b"\0")


def group(number: int, name: str) -> bytes:
    return struct.pack("<bb", len(name), -number) + name.encode() + word(3) + b"\0"


def parameter(name: str, kind: int, dimensions: list[int], data: bytes, number: int = 1) -> bytes:
    return (struct.pack("<bb", len(name), number) + name.encode()
            + word(5 + len(dimensions) + len(data)) + struct.pack("<bB", kind, len(dimensions))
            + bytes(dimensions) + data + b"\0")  # no description


def texts(name: str, values: list[str | bytes]) -> bytes:
    content = [value if isinstance(value, bytes) else value.encode() for value in values]
    return parameter(name, -1, [8, len(content)], b"".join(text.ljust(8) for text in content))


@dataclass
class C3dExample:
    """The default positions are multiples of the scale, which integers represent exactly."""
    is_real: bool = True
    scale: float = 0.25  # of integers
    rate: float = 200.0
    unit: str | None = "mm"
    labels: list[str | bytes] = field(default_factory=lambda: ["base", "tip"])
    frames: int = 3
    positions: list[float] = field(default_factory=lambda: [0.25 * i - 2.0 for i in range(18)])
    residuals: list[float] = field(default_factory=list)  # (frames, markers); empty: all seen
    analog_words: int = 0  # per frame
    used: float | None = None  # POINT:USED as a real; None: the number of labels
    last_frame: int | None = None  # of the header; None: the number of frames
    labels_parameter: bytes | None = None
    more: bytes = b""  # entries

    def header(self) -> bytes:
        last = self.frames if self.last_frame is None else self.last_frame
        return (b"\x02\x50" + word(len(self.labels)) + word(self.analog_words) + word(1)
                + word(last) + word(0) + real(self.stored_scale()) + word(3)
                + word(self.analog_words) + real(self.rate))

    def stored_scale(self) -> float:
        return -self.scale if self.is_real else self.scale

    def parameters(self) -> bytes:
        count = len(self.labels)
        used = (parameter("USED", 2, [], word(count)) if self.used is None else
                parameter("USED", 4, [], real(self.used)))
        unit = b"" if self.unit is None else parameter("UNITS", -1, [4],
                                                       self.unit.encode().ljust(4))
        labels = self.labels_parameter
        return (b"\x01\x50\x01\x54" + group(1, "POINT") + used
                + parameter("SCALE", 4, [], real(self.stored_scale()))
                + parameter("RATE", 4, [], real(self.rate))
                + parameter("DATA_START", 2, [], word(3)) + unit
                + (texts("LABELS", self.labels) if labels is None else labels) + self.more
                + b"\0\0")

    def number(self, value: float) -> bytes:
        return real(value) if self.is_real else struct.pack("<h", int(value))

    def data(self) -> bytes:
        content = bytearray()
        markers, scale = len(self.labels), 1.0 if self.is_real else self.scale
        residuals = self.residuals or [0.0] * (self.frames * markers)
        for i in range(self.frames):
            for point in range(i * markers, (i + 1) * markers):
                for value in self.positions[3 * point:3 * point + 3]:
                    content += self.number(value / scale)
                content += self.number(residuals[point])
            content += self.number(7.0) * self.analog_words
        return bytes(content)

    def content(self) -> bytes:
        parameters = padded(self.parameters())
        assert len(parameters) == 512, "the data begin in block 3"
        return padded(self.header()) + parameters + padded(self.data())
