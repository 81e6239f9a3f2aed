# SPDX-License-Identifier: BSD-3-Clause
"""Finds out how a text table is written: delimiter, decimal sign, and where its rows are.

The rows of a table are the longest run of lines of equal kind. Lines of a header that contain
numbers (samples, offsets, scales) form shorter runs."""
from __future__ import annotations

import csv
import re
from dataclasses import dataclass

from recording.clock_times import CLOCK
from recording.refusal import Refusal

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
DECIMAL_KEY = re.compile(r"decimal[_ ]separator\W*?,")
ONE_DECIMAL_COMMA = re.compile(r"[+-]?\d+,(\d{2,})")
GROUPED_DIGITS = re.compile(r"[+-]?\d{1,3}((,\d{3})+\.\d+|(\.\d{3})+,\d+)")
FEWEST_GROUPED = 3  # a header may have one
GAPS = ("", "nan", "na", "n/a", "null", "none", "-nan", "#n/a")
FORMS = [(delimiter, decimal) for delimiter in (";", "\t", ",", " ") for decimal in (".", ",")
         if delimiter != decimal]
MOST_PROBED = 4000
DELIMITERS = {",": ",", ";": ";", "tab": "\t", "space": " "}


@dataclass(frozen=True)
class TextForm:
    delimiter: str
    decimal: str


def cells_of(line: str, delimiter: str) -> list[str]:
    """The cells without blanks around them and without the empty ones at the end."""
    if '"' in line:
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error as error:
            raise Refusal(f"it is not a table ({error})") from None
    else:
        cells = line.split(None if delimiter == " " else delimiter)
    cells = [cell.strip() for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def is_number(cell: str, decimal: str) -> bool:
    if decimal == ",":
        if "." in cell:
            return False
        cell = cell.replace(",", ".")
    return NUMBER.fullmatch(cell) is not None


def is_value(cell: str, decimal: str) -> bool:
    """A number or a time of day."""
    return is_number(cell, decimal) or (":" in cell and CLOCK.fullmatch(cell) is not None)


def score_of(line: str, form: TextForm, fewest: int) -> int:
    """Numbers less other cells of a line that can be a row; 0 for a line that cannot."""
    cells = cells_of(line, form.delimiter)
    filled = [cell for cell in cells if cell.lower() not in GAPS]
    numbers = sum(is_value(cell, form.decimal) for cell in filled)
    if numbers < fewest or 2 * numbers < len(filled) or line.lstrip().startswith("#"):
        return 0
    return max(1, 2 * numbers - len(filled))


@dataclass
class Run:
    """Lines [begin, end) that can be rows; blank lines may be between them."""
    begin: int
    end: int
    rows: int
    score: int


def is_row_with_texts(line: str, form: TextForm, width: int) -> bool:
    """Whether a line can be a row whose readings are texts ("OVER"): a number and as many cells."""
    cells = cells_of(line, form.delimiter)
    return 1 < len(cells) == width and is_value(cells[0], form.decimal)


def longest_run(lines: list[str], form: TextForm, fewest: int) -> Run:
    best = current = Run(0, 0, 0, 0)
    width = 0
    for i, line in enumerate(lines):
        if not line.strip():
            continue
        score = score_of(line, form, fewest)
        is_row = score > 0 or (current.rows > 0 and is_row_with_texts(line, form, width))
        if score > 0:
            width = len(cells_of(line, form.delimiter))
        if not is_row:
            current = Run(i + 1, i + 1, 0, 0)
            continue
        if current.rows == 0:
            current = Run(i, i, 0, 0)
        current = Run(current.begin, i + 1, current.rows + 1, current.score + score)
        if (current.rows, current.score) > (best.rows, best.score):
            best = current
    return best


def written_decimal(lines: list[str]) -> str | None:
    """A comma if the header names it the decimal sign (LabVIEW), or if all numbers are of one column
    like 5,0123: as many digits behind each comma, and leading zeros among them."""
    for line in lines:
        if DECIMAL_KEY.fullmatch(line.strip().lower()):
            return ","
    numbers = [line.strip() for line in lines if line.strip() and line.strip()[0] in "+-0123456789"]
    found = [ONE_DECIMAL_COMMA.fullmatch(number) for number in numbers]
    if len(found) < 12 or not all(found) or len({len(match[1]) for match in found}) > 1:
        return None
    return "," if any(match[1].startswith("0") for match in found) else None


def separates(form: TextForm, lines: list[str], run: Run) -> bool:
    """Whether the delimiter occurs in the rows, also next to an empty cell."""
    return any(form.delimiter in line for line in lines[run.begin:run.end])


def refuse_grouped_digits(lines: list[str], delimiter: str | None, first_line: int):
    """Numbers like 1,999.5 and 1.999,5 are ambiguous next to 1,999 (2 or 1999), so none is read. A
    line without the delimiter, like 5,123.4, may contain two numbers between commas."""
    for sign in [delimiter] if delimiter else DELIMITERS.values():
        grouped = [(number, cell) for number, line in enumerate(lines, first_line)
                   if sign in line.strip() for cell in cells_of(line, sign)
                   if GROUPED_DIGITS.fullmatch(cell)]
        if len(grouped) >= FEWEST_GROUPED:
            number, cell = grouped[0]
            raise Refusal(f'line {number}: the digits of "{cell}" are in groups; export the numbers '
                          "without a separator of thousands")


def form_and_run(lines: list[str], delimiter: str | None, decimal: str | None,
                 first_line: int) -> tuple[TextForm, Run]:
    """The form with the longest run of rows of two numbers; of one number if none has two."""
    probed = lines[:MOST_PROBED]
    decimal = decimal or written_decimal(probed)
    quoted = [(",", ",")] if any('"' in line for line in probed) else []  # "1,5","2,5"
    forms = [TextForm(*form) for form in FORMS + quoted
             if delimiter in (None, form[0]) and decimal in (None, form[1])]
    if not forms:
        raise Refusal("the decimal sign and the delimiter are both a comma; state another "
                      "[source] delimiter or decimal")
    refuse_grouped_digits(probed, delimiter, first_line)
    for fewest in (2, 1):
        runs = [(longest_run(probed, form, fewest), form) for form in forms]
        run, form = max(runs, key=lambda found: (found[0].rows, found[0].score,
                                                 separates(found[1], probed, found[0])))
        if run.rows >= 2:
            return form, run
    stated = [word for word, value in (("delimiter", delimiter), ("decimal", decimal)) if value]
    other = f" with the stated {' and '.join(stated)}" if stated else ""
    shown = next((line.strip() for line in lines if line.strip()), "")
    raise Refusal(f"it has no two lines with two numbers each{other} (line {first_line} is "
                  f"\"{shown[:60]}\"); a table with a time column and a column of readings is needed")
