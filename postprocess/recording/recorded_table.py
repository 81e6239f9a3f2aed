# SPDX-License-Identifier: BSD-3-Clause
"""A recording as a table of columns, whatever its file was, with what was assumed to read it."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from recording.text_form import TextForm

MOST_LINES_NAMED = 3


@dataclass
class Assumption:
    """Something that the file does not state, and the key of the mapping that states it."""
    text: str
    key: str

    def __str__(self) -> str:
        return f"{self.text}   ({self.key})"


@dataclass
class StatedRate:
    """Samples per second as a header states it; `source` is the header's line."""
    hertz: float
    source: str


@dataclass
class RecordedTable:
    """Columns of equal length. A numeric column is an array of float64 (a gap is NaN) or int64; a
    column of text is an array of objects. `lines` are the rows' lines in a text file."""
    names: list[str]
    columns: list[np.ndarray]
    units: list[str | None] = field(default_factory=list)
    lines: np.ndarray | None = None
    rate: StatedRate | None = None
    length_unit: str | None = None  # of all positions, as a header states it
    has_markers: bool = False
    form: TextForm | None = None  # of a text
    clocks: list[int] = field(default_factory=list)  # columns of times of day, in s from the first
    skip_lines: int = 0  # ahead of the names of a text's columns
    assumptions: list[Assumption] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    exact_texts: Callable[[int], list[str]] | None = None  # of a column's cells
    titles: list[str] = field(default_factory=list)  # as written, may repeat; a name where empty

    def __post_init__(self):
        self.units = self.units or [None] * len(self.names)
        self.titles = [title or name for title, name in
                       zip(self.titles or self.names, self.names, strict=True)]
        for k, column in enumerate(self.columns):
            infinite = np.flatnonzero(np.isinf(column)) if column.dtype.kind == "f" else []
            if len(infinite):
                self.columns[k] = np.where(np.isinf(column), np.nan, column)
                self.notes.append(f'column "{self.names[k]}": {counted(len(infinite), "reading")} '
                                  f"{is_or_are(len(infinite))} infinite, which is a gap "
                                  f"({self.where(infinite)})")

    @property
    def row_count(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    def is_numeric(self, k: int) -> bool:
        return self.columns[k].dtype.kind in "if"

    def values(self, k: int) -> np.ndarray:
        return self.columns[k].astype(float)

    def where(self, rows: np.ndarray) -> str:
        """"lines 8, 9, 10 and 4 more" of a text; rows, counted from 1, of other files."""
        numbers = self.lines[rows] if self.lines is not None else np.asarray(rows) + 1
        word = "line" if self.lines is not None else "row"
        return word + ("s " if len(numbers) > 1 else " ") + spans_text(numbers)


def spans_text(numbers) -> str:
    """"8–14, 60 and 3 more": consecutive numbers as spans."""
    numbers = [int(n) for n in numbers]
    spans: list[list[int]] = []
    for number in numbers:
        if spans and number == spans[-1][1] + 1:
            spans[-1][1] = number
        else:
            spans.append([number, number])
    shown = spans[:MOST_LINES_NAMED]
    text = ", ".join(f"{a}" if a == b else f"{a}–{b}" for a, b in shown)
    rest = len(numbers) - sum(b - a + 1 for a, b in shown)
    return text + (f" and {rest} more" if rest else "")


def is_or_are(count: int) -> str:
    return "is" if count == 1 else "are"


def counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
