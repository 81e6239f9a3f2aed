# SPDX-License-Identifier: BSD-3-Clause
"""Turns the time column of a recording into seconds.

Traps: a unit that no name states; seconds, ms, µs or ns since 1970, which need exact arithmetic
before they are rounded to a double; stamps that are rounded and therefore repeat; clocks that step
back. Nothing is repaired unless the mapping says so."""
from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from recording.recorded_table import Assumption, RecordedTable, counted
from recording.refusal import Refusal

UNITS = {"s": Fraction(1), "ms": Fraction(1, 10**3), "us": Fraction(1, 10**6),
         "ns": Fraction(1, 10**9), "min": Fraction(60), "h": Fraction(3600),
         "day": Fraction(86400)}
WORDS = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds",
         "min": "minutes", "h": "hours", "day": "days"}
COUNTERS = (2**16, 2**32)  # states after which a counter returns to 0
SERIAL_DAYS = (36_526.0, 73_051.0)  # of spreadsheets: 2000 to 2100
SHORTEST_STEP, LONGEST_STEP = 1e-8, 1.0  # s between samples of a swing that can be analysed
YEARS = (1e9, 4.2e9)  # s since 1970: 2001 to 2103
EPOCH = 1e6  # s: larger times are not those since the start of a record


@dataclass
class Times:
    """`seconds` count from `origin` (s on the recording's clock); `kept` are the rows of the
    table, in order."""
    seconds: np.ndarray
    kept: np.ndarray
    origin: Fraction


def guessed_unit(values: np.ndarray) -> str:
    """The unit in which the stamps are since 1970, or else the first with a plausible step."""
    first = float(values[0])
    step = median_step(values.astype(float))
    if SERIAL_DAYS[0] <= first <= SERIAL_DAYS[1] and 0.0 < step < 1e-5:
        return "day"
    for unit in ("s", "ms", "us", "ns"):
        if YEARS[0] <= first * UNITS[unit] <= YEARS[1]:
            return unit
    return next((unit for unit, second in UNITS.items()
                 if SHORTEST_STEP <= step * float(second) <= 0.25), "s")


def median_step(values: np.ndarray) -> float:
    steps = np.diff(values)
    steps = steps[np.isfinite(steps) & (steps > 0)]
    return float(np.median(steps)) if steps.size else 0.0


def rate_of(seconds: np.ndarray) -> float:
    """Samples per second: the mean over the steps that are no gaps. Rounded stamps have a median step
    that is off."""
    steps = np.diff(seconds)
    usual = steps[steps < 1.5 * np.median(steps)]
    return 1.0 / float(np.mean(usual)) if usual.size else 1.0 / float(np.median(steps))


def exact_stamps(table: RecordedTable, k: int) -> list[Fraction] | None:
    """The stamps as they are written, where doubles would round them."""
    column = table.columns[k]
    if column.dtype.kind == "i":
        return [Fraction(int(value)) for value in column]
    if table.exact_texts is None or not np.all(np.isfinite(column)):
        return None
    texts = table.exact_texts(k)
    return [Fraction(text.replace(",", ".")) for text in texts]


def stamps_in_seconds(table: RecordedTable, k: int, unit: str) -> tuple[np.ndarray, Fraction]:
    """Seconds since the origin, which is 0 unless the stamps are larger than a record's times."""
    name, column = table.names[k], table.columns[k]
    if not table.is_numeric(k):
        raise Refusal(f'column "{name}" contains text, such as "{str(column[0])[:30]}"; a time is a '
                      "number, or a time of day like 10:11:12.345")
    if k in table.clocks:
        return column, Fraction(0)
    scale = UNITS[unit]
    values = column.astype(float)
    missing = np.flatnonzero(~np.isfinite(values))
    if missing.size:
        raise Refusal(f'the time is missing in {counted(missing.size, "row")} of column "{name}" '
                      f"({table.where(missing)}); remove the rows, or state [time] rate_hz instead "
                      "of the column")
    if abs(values[0]) * float(scale) < EPOCH:
        return values * float(scale) if scale != 1 else values, Fraction(0)
    exact = exact_stamps(table, k)
    exact = exact or [Fraction(value) for value in values]
    return np.array([float((stamp - exact[0]) * scale) for stamp in exact]), exact[0] * scale


def unwrapped(column: np.ndarray) -> tuple[np.ndarray, int]:
    """Counts of which some returned to 0 after 2^16 or 2^32, as of a microcontroller, and the number
    of states; 0 for others. After a return the steps must be as before."""
    back = np.flatnonzero(np.diff(column) < 0)
    for states in COUNTERS if back.size and np.all(np.isfinite(column)) else ():
        if column.min() < 0 or column.max() >= states or np.any(column != np.floor(column)):
            continue
        steps = np.diff(column.astype(np.int64)) % states
        if steps.max() <= 3 * np.median(steps):
            return int(column[0]) + np.concatenate([[0], np.cumsum(steps)]), states
    return column, 0


def check_step(seconds: np.ndarray, name: str, unit: str, raw: np.ndarray | None):
    """Refuses a sampling interval that no swing can be analysed with, with the plausible unit."""
    step = median_step(seconds)
    if step == 0.0 or SHORTEST_STEP <= step <= LONGEST_STEP:
        return
    better = guessed_unit(raw) if raw is not None else unit
    remedy = ("check that this column is the time" if better == unit else
              f'with unit = "{better}" ({WORDS[better]}{since_1970(raw, better)}) it would be '
              f"{step * float(UNITS[better] / UNITS[unit]):.4g} s")
    raise Refusal(f'[time] column = "{name}", unit = "{unit}": a sampling interval of {step:.3g} s '
                  f"is not plausible for a swing ({SHORTEST_STEP:g} to {LONGEST_STEP:g} s is "
                  f"allowed); {remedy}")


def since_1970(raw: np.ndarray, unit: str) -> str:
    is_epoch = YEARS[0] <= float(raw[0]) * float(UNITS[unit]) <= YEARS[1]
    return " since 1970" if is_epoch and unit != "day" else ""


def resolution_of(seconds: np.ndarray) -> float:
    """The step to which the stamps are rounded: the smallest between different stamps."""
    steps = np.diff(seconds)
    return float(np.min(steps[steps > 0])) if np.any(steps > 0) else 0.0


def are_later_than_all_before(seconds: np.ndarray) -> np.ndarray:
    return seconds > np.concatenate([[-np.inf], np.maximum.accumulate(seconds)[:-1]])


def likely_repair(stamps: np.ndarray) -> str | None:
    """What a mapping is proposed to say on stamps that repeat or go back; None if they ascend."""
    steps = np.diff(unwrapped(stamps)[0])
    if np.any(steps < 0):
        return "drop"
    return "spread" if np.any(steps == 0) else None


def refuse_set_back(table: RecordedTable, name: str, seconds: np.ndarray):
    """Refuses times of which more than a few rows repeat earlier ones: dropping them would join two
    records, or leave out a part of one."""
    back = np.flatnonzero(np.diff(seconds) < 0) + 1
    overlap = int(np.sum(~are_later_than_all_before(seconds)))
    if back.size == 0 or overlap <= max(3 * back.size, 0.01 * len(seconds)):
        return
    jump = seconds[back[0] - 1] - seconds[back[0]]
    raise Refusal(f'column "{name}" goes back by {jump:.4g} s ({table.where(back)}), and '
                  f"{counted(overlap, 'row')} from there on repeat earlier times. If the samples go on "
                  "without a pause, state [time] rate_hz instead of the column; if the file "
                  "contains two records, split it there")


def refuse_order(table: RecordedTable, name: str, seconds: np.ndarray):
    """Names the stamps that repeat or go back, and the keys that repair them."""
    steps = np.diff(seconds)
    back, repeated = np.flatnonzero(steps < 0) + 1, np.flatnonzero(steps == 0) + 1
    slope = np.polyfit(np.arange(len(seconds)), seconds, 1)[0]
    if back.size:
        raise Refusal(f'column "{name}": {counted(back.size, "stamp")} '
                      f'{"is" if back.size == 1 else "are"} earlier than the one before '
                      f"({table.where(back)}): the clock was set back, or two records are in the "
                      'file. Remove them, or write [time] repeated_times = "drop" to leave out '
                      "rows whose stamp is not later than all before")
    if repeated.size:
        share = len(seconds) / repeated.size
        raise Refusal(f'column "{name}": {counted(repeated.size, "stamp")} of {len(seconds)} (one '
                      f"in {share:.3g}) repeat{'s' if repeated.size == 1 else ''} the one before "
                      f"({table.where(repeated)}): the stamps are rounded to "
                      f"{1e3 * resolution_of(seconds):.3g} ms, and the samples are closer. Write "
                      '[time] repeated_times = "spread" (samples at equal distances), "drop" '
                      f"(leave out the repeated ones), or rate_hz = {1.0 / slope:.4g} instead of the "
                      "column")


def repaired(seconds: np.ndarray, repair: str) -> tuple[np.ndarray, np.ndarray, str]:
    """Times that ascend, the rows that are kept, and what was done."""
    rows = np.arange(len(seconds))
    if repair == "drop":
        kept = are_later_than_all_before(seconds)
        return seconds[kept], rows[kept], f"{np.sum(~kept)} rows are left out"
    slope, offset = np.polyfit(rows, seconds, 1)
    line = slope * rows + offset
    resolution = resolution_of(seconds)
    if np.max(np.abs(seconds - line)) <= 1.01 * resolution:
        return line, rows, f"all samples are {1e3 * slope:.6g} ms apart ({1 / slope:.6g} Hz)"
    first = np.concatenate([[True], np.diff(seconds) > 0])
    knots = np.append(rows[first], len(rows))
    values = np.append(seconds[first], seconds[-1] + median_step(seconds))
    return (np.interp(rows, knots, values), rows,
            "samples of one stamp are spread over the time to the next")


def times_of(table: RecordedTable, column: int | None, unit: str, rate: float | None,
             repair: str | None) -> tuple[Times, list[Assumption]]:
    """`rate`, in Hz, replaces a column, or is that of the numbers of frames."""
    count = table.row_count
    if column is None:
        return Times(np.arange(count) / rate, np.arange(count), Fraction(0)), []
    name, raw = table.names[column], table.columns[column]
    assumed = []
    if unit == "frame":
        seconds, origin = table.values(column) / rate, Fraction(0)
    else:
        if table.is_numeric(column):
            table.columns[column], states = unwrapped(raw)
            if states:
                assumed.append(Assumption(f'"{name}" counts to {states - 1} and returns to 0',
                                          "[time] rate_hz replaces the column"))
        seconds, origin = stamps_in_seconds(table, column, unit)
        check_step(seconds, name, unit, raw if table.is_numeric(column) else None)
    if origin:
        assumed.append(Assumption(f"times count from the first stamp, {float(origin):.6f} s on the "
                                  "recording's clock", "[time] rate_hz replaces the column"))
    kept = np.arange(count)
    if np.any(np.diff(seconds) <= 0):
        refuse_set_back(table, name, seconds)
        if repair is None or (repair == "spread" and np.any(np.diff(seconds) < 0)):
            refuse_order(table, name, seconds)
        seconds, kept, done = repaired(seconds, repair)
        assumed.append(Assumption(f"stamps that repeat: {done}", "[time] repeated_times"))
    return Times(seconds, kept, origin), assumed
