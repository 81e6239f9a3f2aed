# SPDX-License-Identifier: BSD-3-Clause
"""Reads the parameters of a C3D file, which name and describe its data."""
from __future__ import annotations

import math
import re
import struct
from dataclasses import dataclass, field

from recording.refusal import Refusal

INTEL = 84  # the fourth byte of the parameter section: the order of bytes
BLOCK = 512
LARGEST_SECTION = 255 * BLOCK  # its header counts blocks in one byte, which some programs get wrong
FORMATS = {1: "<B", 2: "<H", 4: "<f"}  # of a parameter's elements, by its type


def refusal(text: str) -> Refusal:
    return Refusal(f"not a C3D file that can be read: {text}")


def plain(value: float) -> str:
    return repr(value).removesuffix(".0")


def printable(content: bytes) -> str:
    """The text with a question mark for each control character."""
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]", "?", text)


class Content:
    """The bytes of a whole file; a read behind their end is refused."""

    def __init__(self, content: bytes | bytearray):
        self.content = content

    def __len__(self) -> int:
        return len(self.content)

    def number(self, form: str, offset: int) -> float:
        self._check(offset, struct.calcsize(form))
        return struct.unpack_from(form, self.content, offset)[0]

    def byte(self, offset: int) -> int:
        return self.number("<B", offset)

    def word(self, offset: int) -> int:
        return self.number("<H", offset)

    def text(self, offset: int, length: int) -> bytes:
        self._check(offset, length)
        return bytes(self.content[offset:offset + length]).rstrip(b" \0")

    def _check(self, offset: int, length: int):
        if offset + length > len(self.content):
            raise refusal(f"it ends after {len(self.content)} bytes, data was expected at byte "
                          f"{offset}")


@dataclass
class Parameter:
    numbers: list[float] = field(default_factory=list)
    texts: list[bytes] = field(default_factory=list)


Parameters = dict[bytes, Parameter]  # b"GROUP:NAME" in capitals


@dataclass
class Entry:
    """The header of a parameter, or of the group −group if `group` is negative."""
    begin: int
    group: int
    name: bytes
    after_name: int  # position of the offset to the next entry


def entry_at(content: Content, at: int) -> Entry:
    length = abs(content.number("<b", at))  # negative for locked parameters
    return Entry(at, content.number("<b", at + 1), content.text(at + 2, length).upper(),
                 at + 2 + length)


def element_count(entry: Entry, dimensions: list[int], size: int, room: int) -> int:
    """Elements that do not fit into the entry's room are refused before they are read; overlapping
    entries would need memory proportional to the square of the file's size."""
    count = math.prod(dimensions)
    if count * size > room:
        raise refusal(f"parameter {printable(entry.name)} at byte {entry.begin} = "
                      f"{' x '.join(map(str, dimensions))} elements of {size} bytes: its entry "
                      f"ends after {room} bytes")
    return count


def parameter_of(content: Content, entry: Entry, end: int) -> Parameter:
    """The values between the header and `end`, where the next entry or the section's end is."""
    at = entry.after_name + 4
    kind, rank = content.number("<b", at - 2), content.byte(at - 1)
    dimensions = [content.byte(at + k) for k in range(rank)]
    at += rank
    room = max(0, end - at)
    if kind == -1:  # the first dimension is the length of each text
        length = dimensions[0] if dimensions else 1
        letters = element_count(entry, dimensions, 1, room)
        return Parameter(texts=[content.text(at + k, length)
                                for k in (range(0, letters, length) if letters else ())])
    if kind not in FORMATS:
        raise refusal(f"parameter {printable(entry.name)} has the type {kind}: must be -1 (text), "
                      "1 (byte), 2 (integer) or 4 (real)")
    return Parameter([content.number(FORMATS[kind], at + k * kind)
                      for k in range(element_count(entry, dimensions, kind, room))])


def parameters_at(content: Content, begin: int) -> Parameters:
    """The parameters of the section that begins at byte `begin`."""
    processor = content.byte(begin + 3)
    if processor != INTEL:
        raise refusal(f"processor type {processor}; only files of type {INTEL} (Intel) are read")
    groups: dict[int, bytes] = {}
    found: list[tuple[Entry, Parameter]] = []
    at = begin + 4
    section_end = min(len(content), begin + LARGEST_SECTION)
    while at + 2 <= section_end:
        entry = entry_at(content, at)
        if entry.after_name == at + 2 or entry.group == 0:
            break
        offset = content.word(entry.after_name)
        at = entry.after_name + offset
        if entry.group < 0:
            groups[-entry.group] = entry.name
        else:
            end = min(at, section_end) if offset else section_end
            found.append((entry, parameter_of(content, entry, end)))
        if offset == 0:
            break
    return {groups.get(entry.group, b"") + b":" + entry.name: value for entry, value in found}


def stated(parameters: Parameters, key: str, otherwise: str, value: float) -> tuple[str, float]:
    """A parameter's name and number, or those of the header field that replaces it."""
    numbers = parameters.get(key.encode(), Parameter()).numbers
    return (key, float(numbers[0])) if numbers else (otherwise, float(value))
