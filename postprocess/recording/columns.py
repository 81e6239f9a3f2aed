# SPDX-License-Identifier: BSD-3-Clause
"""Tells from the names and the numbers of columns which is the time and what the others measure."""
from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from recording.recorded_table import RecordedTable
from recording.refusal import Refusal
from recording.time_stamps import guessed_unit

UNITS = {"displacement": ("mm", "m", "um"), "velocity": ("m/s", "mm/s"),
         "acceleration": ("m/s2", "mm/s2", "g"), "strain": ("m/m", "um/m")}
SPELLINGS = {unit: unit for units in UNITS.values() for unit in units} | {
    "m_s2": "m/s2", "mm_s2": "mm/s2", "m/s/s": "m/s2", "m_s": "m/s", "mm_s": "mm/s", "mps": "m/s",
    "ue": "um/m", "uε": "um/m", "ustrain": "um/m", "microstrain": "um/m", "um_m": "um/m",
    "meter": "m", "meters": "m", "metre": "m", "metres": "m", "millimeter": "mm",
    "millimeters": "mm", "millimetre": "mm", "micron": "um"}
WORDS = {"acceleration": r"acc.*|a[xyz]?", "velocity": r"vel.*|v[xyz]?",
         "strain": r"strain.*|eps.*",
         "displacement": r"disp.*|x|y|z|defl.*|laser.*|pos.*|weg.*|tip.*"}
OTHER_QUANTITY = re.compile(r"rot.*|angle.*|gyro.*|mag.*|temp.*|force.*|load.*|stress.*|pressure.*")
VOLTAGES = ("v", "mv", "volt", "volts")
# Units of columns that a stem's motion does not have.
FOREIGN_UNITS = {"°c", "degc", "deg", "rad", "n", "kn", "a", "ma", "hz"}
TIME_SPELLINGS = {"s": "s", "sec": "s", "second": "s", "seconds": "s", "ms": "ms", "us": "us",
                  "ns": "ns", "milliseconds": "ms", "microseconds": "us", "nanoseconds": "ns",
                  "millis": "ms", "msec": "ms", "micros": "us", "usec": "us", "nsec": "ns",
                  "min": "min", "minutes": "min", "hours": "h", "days": "day"}
# Columns about a reading: no motion, but they may say that a reading is invalid.
FLAG_NAME = re.compile(r"(.*[\s_.])?(sigma|status|status_?flag|flag|valid|validity|quality|lost|"
                       r"state|error|match|confidence|likelihood|score|visible|visibility|overload|"
                       r"overrange|trigger)([\s_.].*)?",
                       re.IGNORECASE)
INSTRUMENT = re.compile(r"laser|lvdt|sensor|probe|gauge|\bch(annel)?\b", re.IGNORECASE)
MOST_SENSORS = 8
MOVING_SHARE = 0.05  # of the scatter of the record; held frames scatter by less


@dataclass
class Sensor:
    """`unit` is None if neither name nor header states one of the quantity."""
    name: str
    quantity: str
    unit: str | None
    is_guess: bool
    is_unit_usual: bool = False  # the usual unit of such files, not in the name
    is_voltage: bool = False
    is_of_instrument: bool = False


@dataclass
class Record:
    """The columns of a table by their likely meaning. `time` is None if it has no time column."""
    time: str | None
    time_unit: str
    is_unit_guess: bool
    sensors: list[Sensor]
    unused: list[str]
    begins_moving: bool = False

    @property
    def heights(self) -> list[Sensor]:
        """Columns that are positions of the stem, as of a tracked point, not of an instrument."""
        units = {sensor.unit for sensor in self.sensors if sensor.quantity == "displacement"}
        return [sensor for sensor in self.sensors if sensor.quantity == "displacement"
                and len(units) == 1 and not (sensor.is_guess or sensor.is_voltage
                                             or sensor.is_of_instrument)]


def plain(name: str) -> str:
    for old, new in (("µ", "u"), ("μ", "u"), ("²", "2"), ("**", ""), ("^", ""), ("*", "")):
        name = name.replace(old, new)
    return name.strip().lower()


def split_unit(name: str, spellings: dict[str, str]) -> tuple[str, str | None]:
    """The name without its unit, and the unit; None if it has none of these."""
    known = "|".join(re.escape(word) for word in sorted(spellings, key=len, reverse=True))
    found = re.fullmatch(rf"(?:(.*?)[\s_]*[(\[]|(.*?)[\s_,/]|)({known})[)\]]?", plain(name))
    if found is None:
        return plain(name), None
    return found[1] or found[2] or "", spellings[found[3]]


def is_time(name: str) -> bool:
    rest, unit = split_unit(name, TIME_SPELLINGS)
    words = re.findall(r"[^\W_]+", rest)
    return (not words and unit is not None) or bool(words) and bool(
        re.fullmatch(r"t|time.*|zeit.*|date.*|datum|elapsed|seconds|frames?|epoch|x ?value", words[0])
        or re.fullmatch(r"(.*\.)?(t|time|frames?)|x_value", rest) or words[-1] == "elapsed"
        or (unit is not None and {"time", "zeit"} & set(words)))


def ascent(table: RecordedTable, k: int) -> int:
    """2: the column ascends in every row; 1: in nearly all, or it repeats; 0: it does not."""
    if not table.is_numeric(k) or table.row_count < 2:
        return 0
    steps = np.diff(table.columns[k])
    if not np.all(np.isfinite(steps)):
        steps = steps[np.isfinite(steps)]
        if steps.size < 0.5 * table.row_count:
            return 0
    elif np.all(steps > 0):
        return 2
    is_named = is_time(table.titles[k]) and bool(np.any(steps > 0))
    return 1 if np.mean(steps >= 0) > 0.95 and (is_named or np.mean(steps > 0) > 0.3) else 0


def stated_time_unit(table: RecordedTable, k: int) -> str | None:
    if k in table.clocks:
        return "s"
    title = table.titles[k]
    named = TIME_SPELLINGS.get(plain(table.units[k] or "").strip("[]()"))
    found = split_unit(title, TIME_SPELLINGS)[1]
    words = re.findall(r"[^\W_]+", plain(title))
    if found is None and any(word in ("seconds", "sec") for word in words):
        found = "s"
    return named or found or ("frame" if "frame" in title.lower() else None)


def time_column(table: RecordedTable) -> int | None:
    """The time column; None if there is none."""
    order = {k: ascent(table, k) for k in range(len(table.names))}
    named = [k for k, found in order.items() if found and is_time(table.titles[k])]
    if named:  # times before frames, a stated unit before a guess, an ascent in every row first
        return min(named, key=lambda k: ("frame" in table.titles[k].lower(),
                                         stated_time_unit(table, k) is None, -order[k]))
    usable = [k for k, found in order.items() if found == 2]
    usable.sort(key=lambda k: bool(np.all(np.diff(table.columns[k]) == 1)))  # a counter last
    named = [k for k, title in enumerate(table.titles)
             if is_time(title) and (table.is_numeric(k) or not usable)]
    if named and not table.rate:
        refuse_descent(table, named[0])
    if usable and not named:
        return usable[0]
    return None


def refuse_descent(table: RecordedTable, k: int):
    reason = "contains text"
    if table.is_numeric(k):
        back = np.flatnonzero(np.diff(table.values(k)) < 0) + 1
        reason = (f"goes back {len(back)} times ({table.where(back)})" if back.size
                  else "never changes")
    raise Refusal(f'the time column "{table.titles[k]}" {reason}; correct it, or state [time] '
                  "rate_hz in a mapping")


def time_unit(table: RecordedTable, k: int) -> tuple[str, bool]:
    """The unit, and whether it is a guess."""
    if unit := stated_time_unit(table, k):
        return unit, False
    steps = np.diff(table.columns[k])
    is_count = not is_time(table.titles[k]) and bool(np.all(steps == 1))
    return ("frame" if is_count else guessed_unit(table.columns[k])), True


def quantity_of(text: str) -> str | None:
    """The quantity that a word names; None for another quantity along an axis."""
    words = re.findall(r"[^\W_\d]+", text)
    if any(OTHER_QUANTITY.fullmatch(word) for word in words):
        return None
    return next((quantity for quantity, pattern in WORDS.items()
                 if any(re.fullmatch(pattern, word) for word in words)), None)


def sensor_of(name: str, header_unit: str | None, usual_unit: str | None,
              length_unit: str | None = None, file_name: str = "") -> Sensor:
    """An axis alone (x, y, z) is a coordinate, or what the file's name says."""
    rest, unit = split_unit(name, SPELLINGS)
    unit = SPELLINGS.get(plain(header_unit or "").strip("[]()")) or unit
    named = quantity_of(re.sub(r"\b(channel|ch)[ _]?[a-z]\b", "", rest))
    is_axis = re.fullmatch(r"[xyz]", rest) is not None
    of_file = quantity_of(plain(file_name)) if is_axis else None
    named = of_file or ("displacement" if is_axis else named)
    of_unit = next((quantity for quantity, units in UNITS.items() if unit in units), None)
    quantity = named or of_unit or "displacement"
    if unit is None and quantity == "displacement":
        unit = length_unit
    is_usual = unit is None and quantity == "displacement" and usual_unit is not None
    unit = usual_unit if is_usual else unit
    return Sensor(name, quantity, unit if unit in UNITS[quantity] else None,
                  not (named or of_unit) or of_file is not None, is_usual,
                  plain(header_unit or "").strip("[]()") in VOLTAGES,
                  INSTRUMENT.search(f"{name} {file_name}") is not None)


def contradiction(table: RecordedTable, k: int, stated: str) -> str | None:
    """A sentence if the file states another unit of a column than the mapping; else None."""
    written = (table.units[k] or "").strip("[]()")
    is_voltage = plain(written) in VOLTAGES
    found = written if is_voltage else (SPELLINGS.get(plain(written))
                                        or split_unit(table.titles[k], SPELLINGS)[1])
    if found in (None, stated) or stated == "px":
        return None
    remedy = "state [source] factors" if is_voltage else "the mapping counts"
    return (f'column "{table.titles[k]}" is in {found} by the file, and in {stated} by the mapping: '
            f"{remedy}")


def usual_half_swing(values: np.ndarray) -> float:
    """Samples between passages through the middle; the whole length if it does not swing."""
    seen = np.flatnonzero(np.isfinite(values))
    away = values[seen] - np.median(values[seen])
    far = np.flatnonzero(np.abs(away) > 0.1 * np.max(np.abs(away), initial=0.0))
    sides = np.sign(away[far])
    passages = seen[far[1:][sides[1:] != sides[:-1]]]
    return float(np.median(np.diff(passages))) if passages.size > 1 else float(len(values))


def is_reading(table: RecordedTable, k: int) -> bool:
    """Whether a column may be a motion: numbers that vary, and no flag, time or other quantity."""
    name, unit = table.titles[k], plain(table.units[k] or "").strip("[]()")
    if not table.is_numeric(k) or is_time(name) or FLAG_NAME.fullmatch(name):
        return False
    if unit in FOREIGN_UNITS:
        return False
    values = table.values(k)
    seen = values[np.isfinite(values)]
    if seen.size < 2 or np.all(seen == seen[0]):
        return False
    return not (ascent(table, k) == 2 and np.all(np.diff(values) == np.diff(values)[0]))


def begins_moving(columns: dict[str, np.ndarray]) -> bool:
    """Whether every reading moves within the first quarter of a swing, at least ten samples."""
    for values in columns.values():
        if not np.any(np.isfinite(values)):
            continue
        first = values[:max(10, int(0.5 * usual_half_swing(values)))]
        first = first[np.isfinite(first)]
        if first.size > 1 and first.std() < MOVING_SHARE * np.nanstd(values):
            return False
    return True


def columns_of_other_runs(table: RecordedTable, k: int | None) -> list[int]:
    """Columns that are not read at the times of column k. In a table of several runs a reading's times
    are the nearest ones to its left."""
    if k is None:
        return []
    found, own, times = [], k, table.values(k)
    for n in range(k + 1, len(table.names)):
        if is_time(table.titles[n]) and ascent(table, n) and stated_time_unit(table, n) != "frame":
            others = table.values(n)
            same = np.isclose(times, others, rtol=0.0, atol=0.01 * (times[1] - times[0]))
            own = k if np.all(same | ~np.isfinite(others)) else n
        elif own != k and is_reading(table, n):
            found.append(n)
            table.notes.append(f'column "{table.names[n]}" needs another mapping: its times are those '
                               f'of "{table.names[own]}"')
    return found


def record_of(table: RecordedTable, usual_unit: str | None, file_name: str) -> Record:
    """`usual_unit` is that of displacements whose names state none; times are then in s."""
    k = time_column(table)
    of_header = SPELLINGS.get(plain(table.length_unit or ""))
    others = columns_of_other_runs(table, k)
    readings = [n for n in range(len(table.names))
                if n != k and n not in others and is_reading(table, n)]
    sensors = [sensor_of(table.names[n], table.units[n], usual_unit, of_header, file_name)
               for n in readings]
    named = [sensor for sensor in sensors if not sensor.is_guess]
    sensors = (named or sensors)[:MOST_SENSORS]
    if not sensors:
        texts = [f'"{name}" contains text, such as "{column[0]}"' for name, column
                 in zip(table.names, table.columns) if column.dtype == object and column.size]
        raise Refusal("no column besides the time contains readings that vary"
                      + (f"; {'; '.join(texts[:3])}" if texts else ""))
    used = {sensor.name for sensor in sensors} | ({table.names[k]} if k is not None else set())
    unit, is_guess = time_unit(table, k) if k is not None else ("s", False)
    return Record(table.names[k] if k is not None else None, unit,
                  is_guess and usual_unit is None, sensors,
                  [n for n in table.names if n not in used])
