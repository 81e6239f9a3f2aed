# SPDX-License-Identifier: BSD-3-Clause
"""Reads a table of text as columns: a CSV file of any kind, or an instrument's log."""
from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas

from recording.clock_times import clock_seconds
from recording.decoded_text import decoded_text
from recording.header_facts import names_and_units, stated_rate, unit_of_lengths
from recording.recorded_table import Assumption, RecordedTable, counted, is_or_are, spans_text
from recording.refusal import Refusal
from recording.text_form import (GAPS, TextForm, cells_of, form_and_run, is_number,
                                 is_row_with_texts, is_value, score_of)


@dataclass
class TextOptions:
    """The statements of a mapping about a text; None: to be found out."""
    delimiter: str | None = None
    decimal: str | None = None
    skip_lines: int | None = None
    encoding: str | None = None


WORDS = {",": "comma", ";": "semicolon", "\t": "tabulator", " ": "space"}


def first_row(lines: list[str], form: TextForm, begin: int, end: int) -> int:
    """The first line of a run that has numbers where most of its lines do: a line of a header with
    a name and numbers may be directly above the table."""
    rows = [(i, cells_of(lines[i], form.delimiter)) for i in range(begin, end) if lines[i].strip()]
    tail = rows[len(rows) // 2:]
    width = max(len(cells) for _, cells in tail)
    usual = [sum(k < len(cells) and is_number(cells[k], form.decimal) for _, cells in tail)
             > 0.9 * len(tail) for k in range(width)]
    for i, cells in rows:
        if all(not number or k >= len(cells) or not cells[k] or is_number(cells[k], form.decimal)
               for k, number in enumerate(usual)) and len(cells) >= 0.5 * width:
            return i
    return rows[0][0]


def body_of(lines: list[str], form: TextForm, first: int, fewest: int) -> tuple[list[int], list[int]]:
    """The indices of the rows, and those of other lines that are not blank. The first thousand
    lines and those that begin with a letter are looked at; the rest are rows."""
    rows, others = [], []
    first_cells = cells_of(lines[first], form.delimiter)
    width, begins_with_value = len(first_cells), is_value(first_cells[0], form.decimal)
    for i in range(first, len(lines)):
        line = lines[i]
        if not line.strip():
            continue
        is_probed = i - first < 1000 or line.lstrip()[0] not in "0123456789+-."
        cell = (cells_of(line, form.delimiter) or [""])[0] if is_probed else ""
        is_text_first = begins_with_value and not (cell.lower() in GAPS or
                                                   is_value(cell, form.decimal))
        if is_probed and (is_text_first or score_of(line, form, fewest) == 0) and (
                not is_row_with_texts(line, form, width)):
            others.append(i)
        else:
            rows.append(i)
    return rows, others


def references(names: list[str], cells: list[str]) -> list[str]:
    """The names as a mapping refers to them; the column's number where a name is absent or not
    unique. A name is looked for first, so that a number that is also a name gets a leading 0."""
    def reference(k: int, name: str) -> str:
        if name and names.count(name) == 1:
            return name
        return f"0{k}" if str(k) in cells else str(k)
    return [reference(k, name) for k, name in enumerate(names, 1)]


def converted(column: pandas.Series, decimal: str) -> np.ndarray:
    """Numbers where most cells are numbers, else texts."""
    if column.dtype.kind in "if":
        return column.to_numpy()
    if column.dtype.kind == "b":
        return column.to_numpy().astype(object)
    texts = column.where(column.isna(), column.astype(str).str.strip())
    plain = texts.str.replace(",", ".", regex=False) if decimal == "," else texts
    numbers = pandas.to_numeric(plain, errors="coerce").to_numpy(float)
    filled = int((texts.notna() & (texts != "")).sum())
    if np.isfinite(numbers).sum() > 0.5 * filled:
        return numbers
    return texts.to_numpy(dtype=object)


class TextTable:
    """The parsed body of a text; `cells` reads a column again as it is written."""

    def __init__(self, lines: list[str], form: TextForm, rows: list[int]):
        self.form, self.rows = form, rows
        self.body = "\n".join(lines[i] for i in rows)
        separator = " " if form.delimiter == " " else form.delimiter
        self.width = max((len(lines[i].split()) if form.delimiter == " " else
                          lines[i].count(separator) + 1) for i in rows)

    def read(self, **options) -> pandas.DataFrame:
        separator = r"\s+" if self.form.delimiter == " " else self.form.delimiter
        try:
            return pandas.read_csv(io.StringIO(self.body), sep=separator, header=None,
                                   names=range(self.width), decimal=self.form.decimal,
                                   skipinitialspace=True, index_col=False, low_memory=False,
                                   float_precision="round_trip", **options)
        except (pandas.errors.ParserError, ValueError, OverflowError) as error:
            raise Refusal(f"it is not a table ({str(error).splitlines()[0]})") from None

    def cells(self, k: int) -> list[str]:
        return self.read(usecols=[k], dtype=str)[k].fillna("").str.strip().tolist()


def texts_that_are_gaps(table: RecordedTable, k: int, cells: list[str]) -> str | None:
    """The note on the cells of a numeric column that are not numbers."""
    rows = np.array([i for i, cell in enumerate(cells)
                     if cell and np.isnan(float(table.columns[k][i])) and cell.lower() != "nan"],
                    int)
    if rows.size == 0:
        return None
    return (f'column "{table.names[k]}": {counted(rows.size, "cell")} without a number, such as '
            f'"{cells[rows[0]][:20]}", {"is a gap" if rows.size == 1 else "are gaps"} '
            f"({table.where(rows)})")


def read_clocks(table: RecordedTable):
    """Times of day become seconds from the first."""
    for k, column in enumerate(table.columns):
        if table.is_numeric(k) or (seconds := clock_seconds([str(c) for c in column])) is None:
            continue
        table.columns[k] = np.array([float(second - seconds[0]) for second in seconds])
        table.clocks.append(k)
        table.assumptions.append(Assumption(
            f'times of "{table.names[k]}" count in s from the first, {column[0]}',
            "[time] rate_hz replaces the column"))


def text_table(file: Path, options: TextOptions) -> RecordedTable:
    text, encoding = decoded_text(file, options.encoding)
    lines = re.split(r"\r\n|\r|\n", text)
    skipped = options.skip_lines or 0
    form, run = form_and_run(lines[skipped:], options.delimiter, options.decimal, skipped + 1)
    first = skipped + first_row(lines[skipped:], form, run.begin, run.end)
    fewest = min(2, max(1, sum(is_number(cell, form.decimal)
                               for cell in cells_of(lines[first], form.delimiter))))
    rows, others = body_of(lines, form, first, fewest)
    parsed = TextTable(lines, form, rows)
    frame = parsed.read()
    width = max(len(cells_of(lines[i], form.delimiter)) for i in rows[:1000])
    above = lines[:first]
    names, units, header_lines = names_and_units(above, form, width)
    count = max(width, min(len(names), parsed.width))
    names = (names + [""] * count)[:count]
    first_cells = cells_of(lines[first], form.delimiter) + names
    table = RecordedTable(
        references(names, first_cells),
        [converted(frame[k], form.decimal) if k in frame else np.full(len(frame), np.nan)
         for k in range(count)],
        (list(units) + [None] * count)[:count], np.array(rows) + 1,
        stated_rate(lines[:first], form),
        length_unit=unit_of_lengths(above, form), form=form,
        skip_lines=0 if is_plain(lines, first - header_lines) else first - header_lines,
        exact_texts=parsed.cells, titles=names)
    read_clocks(table)
    for k in range(count):
        if frame[k].dtype == object and table.is_numeric(k) and k not in table.clocks:
            cells = frame[k].fillna("").astype(str).str.strip().tolist()
            note = texts_that_are_gaps(table, k, cells)
            table.notes += [note] if note else []
    if others:
        numbers = np.array(others) + 1
        verb = is_or_are(len(others))
        table.notes.append(f'{counted(len(others), "line")} below the first row {verb} not part of '
                           f"the table and {verb} not read: {spans_text(numbers)} "
                           f'("{lines[others[0]].strip()[:30]}")')
    table.assumptions += form_assumptions(table, options, encoding, first, header_lines)
    return table


def is_plain(lines: list[str], top: int) -> bool:
    """Whether only comments and blank lines are ahead of the table, which need no statement."""
    return all(not line.strip() or line.lstrip().startswith("#") for line in lines[:top])


def form_assumptions(table: RecordedTable, options: TextOptions, encoding: str, first: int,
                     header_lines: int) -> list[Assumption]:
    found, form = [], table.form
    where = f"the table begins at line {first + 1}" + (
        "" if header_lines else ", without a line of names")
    if (table.skip_lines or not header_lines) and options.skip_lines is None:
        found.append(Assumption(where, "[source] skip_lines"))
    if options.delimiter is None and len(table.names) > 1:
        found.append(Assumption(f"cells are separated by a {WORDS[form.delimiter]}",
                                "[source] delimiter"))
    if options.decimal is None and form.decimal == ",":
        found.append(Assumption("the decimal sign is a comma", "[source] decimal"))
    if options.encoding is None and encoding not in ("utf-8", "utf-16"):
        found.append(Assumption(f"the text is encoded as {encoding}", "[source] encoding"))
    return found
