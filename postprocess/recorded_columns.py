# SPDX-License-Identifier: BSD-3-Clause
"""Tells from the names of a table's columns which is the time and what the others measure."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass

from delimited_table import DelimitedTable
from recording_refusal import Refusal

UNITS = {"displacement": ("mm", "m", "um"), "velocity": ("m/s", "mm/s"),
         "acceleration": ("m/s2", "mm/s2", "g"), "strain": ("m/m", "um/m")}
SPELLINGS = {unit: unit for units in UNITS.values() for unit in units} | {
    "m_s2": "m/s2", "mm_s2": "mm/s2", "m/s/s": "m/s2", "m_s": "m/s", "mm_s": "mm/s", "mps": "m/s",
    "ue": "um/m", "uε": "um/m", "ustrain": "um/m", "microstrain": "um/m", "um_m": "um/m"}
WORDS = {"acceleration": r"acc.*|a[xyz]?", "velocity": r"vel.*|v[xyz]?",
         "strain": r"strain.*|eps.*",
         "displacement": r"disp.*|x|y|defl.*|laser.*|pos.*"}
TIME_UNITS = {"s": "s", "sec": "s", "seconds": "s", "ms": "ms", "us": "us"}
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
MOST_SENSORS = 8
MOVING_SHARE = 0.05  # of the scatter of the record; held frames scatter by less


@dataclass
class Sensor:
    """`unit` is None if the name does not state one of the quantity."""
    name: str
    quantity: str
    unit: str | None
    is_guess: bool
    values: list[float | None]
    is_unit_usual: bool = False  # the usual unit of such files, not in the name


@dataclass
class Record:
    time: str
    time_unit: str
    times: list[float]
    is_unit_guess: bool
    sensors: list[Sensor]
    unused: list[str]
    begins_moving: bool


def plain(name: str) -> str:
    for old, new in (("µ", "u"), ("μ", "u"), ("²", "2"), ("**", ""), ("^", ""), ("*", "")):
        name = name.replace(old, new)
    return name.strip().lower()


def split_unit(name: str, spellings: dict[str, str]) -> tuple[str, str | None]:
    """The name without its unit, and the unit; None if it has none of these."""
    known = "|".join(re.escape(word) for word in sorted(spellings, key=len, reverse=True))
    found = re.fullmatch(rf"(?:(.*?)[\s_]*[(\[]|(.*?)[\s_,/]|)({known})[)\]]?",
                         plain(name))
    if found is None:
        return plain(name), None
    return found[1] or found[2] or "", spellings[found[3]]


def is_time(name: str) -> bool:
    rest, unit = split_unit(name, TIME_UNITS)
    words = re.findall(r"[^\W_]+", rest)
    return (not words and unit is not None) or bool(words) and bool(
        re.fullmatch(r"t|time.*|zeit.*|elapsed|frames?", words[0])
        or re.fullmatch(r".*\.(t|time|frames?)", rest))


def ascends(values: list[float | None] | None) -> bool:
    return (values is not None and None not in values
            and all(a < b for a, b in zip(values, values[1:])))


def time_column(table: DelimitedTable) -> int:
    usable = [k for k, values in enumerate(table.columns) if ascends(values)]
    if not usable:
        raise Refusal("no column ascends in every line, as the time must; export the time too")
    named = [k for k in usable if is_time(table.names[k])]
    other = [name for name in table.names if is_time(name)]
    if other and not named:
        raise Refusal(f"the time column '{other[0]}' does not ascend in every line; correct it")
    named.sort(key=lambda k: "frame" in table.names[k].lower())  # stable: times before frames
    return (named or usable)[0]


def time_unit(name: str, times: list[float]) -> tuple[str, bool]:
    """The unit, and whether it is a guess."""
    unit = split_unit(name, TIME_UNITS)[1]
    if unit:
        return unit, False
    if "frame" in name.lower():
        return "frame", False
    is_count = not is_time(name) and all(b - a == 1.0 for a, b in zip(times, times[1:]))
    return ("frame" if is_count else "s"), True


def sensor_of(name: str, values: list[float | None], usual_unit: str | None) -> Sensor:
    rest, unit = split_unit(name, SPELLINGS)
    words = re.findall(r"[^\W_\d]+", rest)
    named = next((quantity for quantity, pattern in WORDS.items()
                  if any(re.fullmatch(pattern, word) for word in words)), None)
    of_unit = next((quantity for quantity, units in UNITS.items() if unit in units), None)
    quantity = named or of_unit or "displacement"
    is_usual = unit is None and quantity == "displacement" and usual_unit is not None
    unit = usual_unit if is_usual else unit
    return Sensor(name, quantity, unit if unit in UNITS[quantity] else None,
                  not (named or of_unit), values, is_usual)


def scatter(values: list[float | None]) -> float:
    """The standard deviation."""
    seen = [value for value in values if value is not None]
    mean = math.fsum(seen) / max(len(seen), 1)
    return math.sqrt(math.fsum((x - mean) ** 2 for x in seen) / max(len(seen), 1))


def begins_moving(sensors: list[Sensor]) -> bool:
    """Whether the first samples of every sensor scatter like a motion."""
    for sensor in sensors:
        count = max(10, len(sensor.values) // 50)
        first = [value for value in sensor.values[:count] if value is not None]
        if len(first) > 1 and scatter(first) < MOVING_SHARE * scatter(sensor.values):
            return False
    return True


def record_of(table: DelimitedTable, usual_unit: str | None) -> Record:
    """`usual_unit` is that of displacements whose names state none; times are then in s."""
    k = time_column(table)
    times, name = table.columns[k], table.names[k]
    varies = {n: values for n, values in zip(table.names, table.columns)
              if values is not None and n != name and not is_time(n)
              and len({value for value in values if value is not None}) > 1}
    sensors = [sensor_of(n, values, usual_unit) for n, values in varies.items()][:MOST_SENSORS]
    if not sensors:
        raise Refusal("no column besides the time contains readings that vary")
    used = {name, *(sensor.name for sensor in sensors)}
    unit, is_guess = time_unit(name, times)
    return Record(name, unit, times, is_guess and usual_unit is None, sensors,
                  [n for n in table.names if n not in used], begins_moving(sensors))
