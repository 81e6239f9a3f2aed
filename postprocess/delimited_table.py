# SPDX-License-Identifier: BSD-3-Clause
"""Finds out how a text table is written: delimiter, decimal sign, header and numeric columns."""
from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from recording_refusal import Refusal

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
GAPS = ("", "NaN", "nan")
FORMS = [(delimiter, decimal) for delimiter in (";", "\t", ",", " ") for decimal in (".", ",")
         if delimiter != decimal]
MOST_PROBED = 2000
MOST_BYTES = 1 << 30


@dataclass
class DelimitedTable:
    """`names` are as a mapping refers to the columns. A column that contains text is None."""
    delimiter: str
    decimal: str
    skip_lines: int
    names: list[str]
    columns: list[list[float | None] | None]


def text_of(file: Path) -> str:
    if file.stat().st_size > MOST_BYTES:
        raise Refusal("it is larger than 1 GiB; export a shorter part of the recording")
    content = file.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise Refusal('it is UTF-16 ("Unicode text" of a spreadsheet); save it as CSV UTF-8')
    if content.startswith(b"PK\x03\x04"):
        raise Refusal("it is a workbook or an archive; save the sheet as CSV")
    if b"\0" in content:
        raise Refusal("it is not a text file; a table of text, .trk, .mat, .npy and .npz are read")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def cells_of(line: str, delimiter: str) -> list[str]:
    """The cells without blanks around them and without the empty ones at the end."""
    if '"' in line:
        cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    else:
        cells = line.split(None if delimiter == " " else delimiter)
    cells = [cell.strip() for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def value_of(cell: str, decimal: str) -> float | None:
    """None if the cell is not a finite number."""
    cell = cell.replace(",", ".") if decimal == "," and "." not in cell else cell
    value = float(cell) if NUMBER.fullmatch(cell) else None
    return value if value is not None and abs(value) < float("inf") else None


def numbers_in(line: str, form: tuple[str, str]) -> int:
    delimiter, decimal = form
    cells = [] if line.lstrip().startswith("#") else cells_of(line, delimiter)
    count = sum(value_of(cell, decimal) is not None for cell in cells)
    return count if count >= 2 else 0


def form_of(lines: list[str]) -> tuple[str, str]:
    """The delimiter and the decimal sign that make most lines rows of two numbers or more."""
    def score(form: tuple[str, str]) -> tuple[int, int]:
        counts = [numbers_in(line, form) for line in lines[:MOST_PROBED]]
        return sum(count > 0 for count in counts), sum(counts)
    best = max(FORMS, key=score)  # the first of equal ones
    if score(best)[0] < 2:
        raise Refusal("it has no two lines with two numbers each; a table with a time column and "
                      "a column of readings is needed")
    return best


def usable_header(line: str, row: list[str], form: tuple[str, str]) -> list[str] | None:
    """The names, if the line above the first row of numbers consists of names."""
    names = cells_of(line, form[0])
    if line.lstrip().startswith("#") or len(names) != len(row):
        return None
    return names if all(value_of(name, form[1]) is None for name in names) else None


def references(cells: list[str], is_header: bool) -> list[str]:
    """The names; where a name is absent or not unique, the column's number. culm looks for a
    name first, so that a number that is also a cell of the first line gets a leading 0."""
    def reference(k: int, cell: str) -> str:
        if is_header and cell and cells.count(cell) == 1:
            return cell
        return f"0{k}" if str(k) in cells else str(k)
    return [reference(k, cell) for k, cell in enumerate(cells, 1)]


def column_of(rows: list[list[str]], k: int, decimal: str) -> list[float | None] | None:
    """The values; None for a column with a text or without two numbers."""
    cells = [row[k] if k < len(row) else "" for row in rows]
    values = [value_of(cell, decimal) for cell in cells]
    if any(value is None and cell not in GAPS for value, cell in zip(values, cells)):
        return None
    return values if sum(value is not None for value in values) >= 2 else None


def table_of(text: str) -> DelimitedTable:
    lines = re.split(r"\r\n|\r|\n", text)
    try:
        form = form_of([line for line in lines if line.strip()])
        first = next(i for i, line in enumerate(lines) if numbers_in(line, form))
        above = [i for i in range(first) if lines[i].strip()]
        row = cells_of(lines[first], form[0])
        header = usable_header(lines[above[-1]], row, form) if above else None
        rows = [cells_of(line, form[0]) for line in lines[first:] if line.strip()]
    except csv.Error as error:
        raise Refusal(f"it is not a table ({error})") from None
    top = above[-1] if header else first
    is_plain = all(lines[i].lstrip().startswith("#") for i in above if i < top)
    return DelimitedTable(
        *form, 0 if is_plain else top, references(header or row, header is not None),
        [column_of(rows, k, form[1]) for k in range(len(row))])
