# SPDX-License-Identifier: BSD-3-Clause
"""Reads what the lines above a table state: the names and units of the columns, and the rate.

LabVIEW (.lvm), Motive, oscilloscopes and data loggers write such lines. A rate is taken only from a
key that names one, with its unit."""
from __future__ import annotations

import re

from recording.recorded_table import StatedRate
from recording.text_form import TextForm, cells_of, is_number, is_value

# In the order of preference: of an exported file, the export's rate counts.
RATE_KEYS = (r"export frame rate", r"(capture |camera )?frame ?rate( \(?(hz|fps)\)?)?", r"fps",
             r"(sampl(e|ing)?[ _]?)(rate|freq\w*)", r"rate", r"abtastrate", r"messrate")
INTERVAL_KEYS = (r"delta[ _]?x", r"sampl(e|ing) (interval|period)", r"x ?increment", r"tinterval",
                 r"time (step|interval|increment)", r"dt", r"δt", r"interval", r"xinc\w*",
                 r"abtastintervall")
FACTORS = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6,
           "ns": 1e-9, "hz": 1.0, "khz": 1e3, "mhz": 1e6, "fps": 1.0, "1/s": 1.0,
           "samples/s": 1.0, "s/s": 1.0}
UNIT_WORDS = {"s", "sec", "second", "seconds", "ms", "us", "ns", "mm", "cm", "m", "um", "metre",
              "meter", "meters", "metres", "millimeters", "volt", "volts", "v", "mv", "g", "m/s",
              "mm/s", "m/s2", "mm/s2", "m/s^2", "m/s²", "hz", "deg", "rad", "n", "kn", "px",
              "pixel", "um/m", "ue", "µε", "µm", "-", "°c", "c", "a", "frames"}

UNIT_KEY = re.compile(r"(y[_ ])?units?([_ ]label)?s?")


def without_brackets(cell: str) -> str:
    return cell.strip().strip("[]()").strip()


def is_unit(cell: str) -> bool:
    inner = without_brackets(cell)
    return inner.lower() in UNIT_WORDS or re.fullmatch(r"[\[(].{1,8}[\])]", cell.strip()) is not None


def key_of(cell: str) -> tuple[str, str | None]:
    """A key in small letters, and the unit in its brackets."""
    plain = cell.strip().strip("#:*").strip()
    found = re.fullmatch(r"(.*?)\s*[\[(](.*?)[\])]", plain)
    return (found[1].lower(), found[2].lower()) if found else (plain.lower(), None)


def pairs_of(line: str, form: TextForm) -> list[tuple[str, list[str]]]:
    """A line's keys and the cells that follow each: "key,value", "key: value", "key = value"."""
    cells = cells_of(line, form.delimiter)
    found = re.fullmatch(r"\s*#?\s*([^:=]+?)\s*[:=]\s*(\S+)(?:\s+(\S+))?\s*", line.strip('"'))
    pairs = [(found[1], [part for part in found.groups()[1:] if part])] if found else []
    pairs += [(cells[k], cells[k + 1:]) for k in range(len(cells) - 1) if cells[k]]
    return pairs


def value_with_unit(values: list[str], unit: str | None, decimal: str) -> float | None:
    """The first value in SI units; the unit is in the key, behind the number or in the next cell."""
    if not values:
        return None
    text, follows = values[0], values[1].lower() if len(values) > 1 else ""
    found = re.fullmatch(r"(\S+?)\s*([a-zµ/]+\d?)", text, re.IGNORECASE)
    if not is_number(text, decimal) and found and is_number(found[1], decimal):
        text, unit = found[1], found[2].lower()
    if not is_number(text, decimal) and not is_number(text, "."):
        return None
    number = float(text.replace(",", "."))
    name = (unit or follows).replace("µ", "u")
    return number * FACTORS.get(name, 1.0) if number > 0.0 else None


def stated_rate(lines: list[str], form: TextForm) -> StatedRate | None:
    """`lines` are those above the table; the preferred key wins."""
    best: tuple[int, StatedRate] | None = None
    for number, line in enumerate(lines, 1):
        for cell, values in pairs_of(line, form):
            key, unit = key_of(cell)
            for rank, pattern in enumerate(RATE_KEYS + INTERVAL_KEYS):
                if not re.fullmatch(pattern, key) or (best and best[0] <= rank):
                    continue
                value = value_with_unit(values, unit, form.decimal)
                if value:
                    hertz = value if rank < len(RATE_KEYS) else 1.0 / value
                    best = rank, StatedRate(hertz, f'line {number}, "{cell.strip()}"')
    return best[1] if best else None


def header_row(line: str, form: TextForm, width: int) -> list[str] | None:
    """The cells of a line of names: the number of a row's cells or up to two more, and most are no numbers.
    Names between spaces may contain one: "Time (s)   Tip (mm)"."""
    marked = line.strip()
    marked = marked[1:].strip() if marked.startswith("#") else line
    cells = cells_of(marked, form.delimiter)
    if form.delimiter == " " and len(cells) != width:
        apart = re.split(r"\s{2,}|\t", marked.strip())
        cells = apart if len(apart) == width else cells
    if not width <= len(cells) <= width + 2 or not any(cells):
        return None
    filled = [cell for cell in cells if cell]
    if 2 * sum(is_number(cell, form.decimal) for cell in filled) >= len(filled):
        return None
    return cells


def names_and_units(above: list[str], form: TextForm,
                    width: int) -> tuple[list[str], list[str | None], int]:
    """Names and units of the columns and the number of lines they take at the end of `above`."""
    filled = [i for i, line in enumerate(above) if line.strip()]
    nothing = [""] * width, [None] * width, 0
    if not filled or (names := header_row(above[filled[-1]], form, width)) is None:
        return nothing
    if above[filled[-1]].lstrip().startswith("#") and len(names) != width:
        return nothing
    top, units = filled[-1], [None] * width
    over = header_row(above[filled[-2]], form, width) if len(filled) > 1 else None
    if over and sum(bool(cell) for cell in over) > 1 and all(is_unit(c) for c in names if c):
        units = [without_brackets(cell) or None for cell in names]
        names, top = over, filled[-2]
    names = with_groups(names, above[:top], form, width)
    labels = unit_labels(above[:top], form)
    units = [unit or (labels[k] if k < len(labels) else None) or None
             for k, unit in enumerate((units + [None] * width)[:len(names)])]
    return names, units, len(above) - top


def with_groups(names: list[str], above: list[str], form: TextForm, width: int) -> list[str]:
    """"tip X" for columns that are named X under a group tip: where names repeat, the cells of the
    lines above distinguish them."""
    rows = above[-8:][::-1]
    rows.sort(key=lambda line: not re.search(r"(^|\W)names?(\W|$)", line.lower()))  # stable
    for line in rows:
        if len(set(names)) == len(names):
            break
        cells = cells_of(line, form.delimiter)
        if not 1 < len(cells) <= width + 2 or is_fact(cells, form):
            continue
        groups, last = [], ""
        for cell in cells + [""] * (len(names) - len(cells)):
            last = cell or last
            groups.append(last)
        if len(set(zip(groups, names))) > len(set(names)):
            repeated = {name for name in names if names.count(name) > 1}
            names = [f"{group} {name}".strip() if name in repeated else name
                     for group, name in zip(groups, names)]
    return names


def is_fact(cells: list[str], form: TextForm) -> bool:
    """Whether a line is a key with values ("X0,0.0,0.0", "Y_Unit_Label,mm,Volts"), and no line of
    names over several columns."""
    values = [cell for cell in cells[1:] if cell]
    return bool(cells[0]) and bool(values) and (
        len(set(values)) == 1 or all(is_value(cell, form.decimal) for cell in values)
        or UNIT_KEY.fullmatch(cells[0].lower()) is not None)


def unit_of_lengths(lines: list[str], form: TextForm) -> str | None:
    """The unit that a line "Length Units,Meters" or "Unit: mm" states for all positions."""
    for line in lines:
        for cell, values in pairs_of(line, form):
            if values and re.fullmatch(r"((length|position) )?units?", key_of(cell)[0]):
                return values[0]
    return None


def unit_labels(above: list[str], form: TextForm) -> list[str]:
    """The units in a line "Y_Unit_Label,mm,Volts", by column."""
    for line in reversed(above):
        cells = cells_of(line, form.delimiter)
        if len(cells) > 1 and UNIT_KEY.fullmatch(cells[0].lower()):
            return ["", *cells[1:]]
    return []
