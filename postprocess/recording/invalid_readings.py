# SPDX-License-Identifier: BSD-3-Clause
"""Finds readings that are no measurements; they become gaps, with their number and place in a note.

Kinds: marks of an overload or of nothing (1e30, 9.9e37, -999, 32767); rows that another column flags
(SIGMA = -1 of digital image correlation, a status); values that repeat while the stem moves: the end
of a sensor's range, or a tracker that keeps its last position.

Traps: a stem that is held still and a coarsely digitised turning point repeat values too. A run of
equal values counts only if the readings on both sides move by several digits per sample, and if it
is shorter than half a swing."""
from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from recording.columns import FLAG_NAME, usual_half_swing
from recording.recorded_table import Assumption, RecordedTable, counted
from recording.refusal import Refusal

SURELY_A_MARK = 1e30
ISOLATED = 2.0  # ranges of the other readings between them and a mark
CONDITION = re.compile(r"\s*(.+?)\s*(<=|>=|!=|==|=|<|>)\s*(\S+)\s*")
COMPARE = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal,
           "=": np.equal, "==": np.equal, "!=": np.not_equal}
FEWEST_EQUAL = 3  # at the end of the range; one more elsewhere
MOST_STATES = 6
# DeepLabCut and SLEAP write one for each tracked point; 0.6 is DeepLabCut's limit (pcutoff).
PROBABILITY = re.compile(r"likelihood|confidence|score|probability", re.IGNORECASE)
LEAST_LIKELY = 0.6
MOVING_DIGITS = 3.0  # per sample


@dataclass
class InvalidOptions:
    """The statements of a mapping; None: to be found out. `keeps_stuck` keeps values that repeat."""
    missing_values: list[float] | None = None
    invalid_if: list[str] | None = None
    keeps_stuck: bool = False


def marks_in(values: np.ndarray) -> list[float]:
    """Values that mark a missing reading: at least 1e30, or far away from all others."""
    seen = values[np.isfinite(values)]
    marks = sorted({float(v) for v in seen[np.abs(seen) >= SURELY_A_MARK]})
    distinct = np.unique(seen[np.abs(seen) < SURELY_A_MARK])
    while distinct.size > 8:
        low, high = distinct[1] - distinct[0], distinct[-1] - distinct[-2]
        k = 0 if low > high else -1
        rest = distinct[1:] if k == 0 else distinct[:-1]
        repeats = int(np.sum(seen == distinct[k]))
        if max(low, high) <= ISOLATED * (rest[-1] - rest[0]) or (
                repeats < 2 and distinct[k] not in (-999.0, -9999.0, 32767.0, -32768.0)):
            break
        marks.append(float(distinct[k]))
        distinct = rest
    return marks


def condition_rows(table: RecordedTable, condition: str) -> np.ndarray:
    found = CONDITION.fullmatch(condition)
    if not found or found[1] not in table.names:
        raise Refusal(f'[source] invalid_if: "{condition}" must be like "SIGMA < 0" with a column '
                      f'of the file; it has {", ".join(table.names[:20])}')
    column = table.columns[table.names.index(found[1])]
    if column.dtype.kind in "if":
        try:
            return COMPARE[found[2]](column, float(found[3]))
        except ValueError:
            raise Refusal(f'[source] invalid_if: "{condition}" compares numbers with a text') from None
    if found[2] not in ("=", "==", "!="):
        raise Refusal(f'[source] invalid_if: "{condition}" orders texts; = and != are allowed')
    return COMPARE[found[2]](column.astype(str), found[3])


def likely_conditions(table: RecordedTable, used: list[str]) -> list[str]:
    """Conditions on columns that are named like flags and say that some rows are invalid."""
    found = []
    for k, name in enumerate(table.names):
        if name in used or not FLAG_NAME.fullmatch(name) or "trigger" in name.lower():
            continue
        column = table.columns[k]
        if table.is_numeric(k):
            values = table.values(k)
            values = values[np.isfinite(values)]
            if PROBABILITY.search(name) and values.size and 0.0 <= values.min() <= values.max() <= 1.0:
                found += [f"{name} < {LEAST_LIKELY}"] if np.median(values) > LEAST_LIKELY else []
                continue
            if np.any(values == -1.0) and np.all((values == -1.0) | (values >= 0.0)):
                found.append(f"{name} < 0")
                continue
            column = values
        states, counts = np.unique(column.astype(str), return_counts=True)
        usual = int(np.argmax(counts))
        if 1 < states.size <= MOST_STATES and counts[usual] > 0.6 * counts.sum():
            found.append(f"{name} != {float(states[usual]):g}" if table.is_numeric(k)
                         else f"{name} != {states[usual]}")
    return found


def report(text: str, key: str, is_assumed: bool, assumed: list[Assumption], notes: list[str]):
    """Adds a note on a statement of the mapping, or else an assumption."""
    if is_assumed:
        assumed.append(Assumption(text, key))
    else:
        notes.append(text)


def flagged_columns(condition: str, names: list[str], used: list[str]) -> list[str]:
    """Those that a condition is about: "tip likelihood" is about "tip x", "SIGMA" about all."""
    column = CONDITION.fullmatch(condition)[1]
    point = f"{column.rpartition(' ')[0]} "
    has_point = any(name.startswith(point) for name in names if name != column)
    return [name for name in used if name.startswith(point)] if has_point else used


def flagged_rows(table: RecordedTable, used: list[str], options: InvalidOptions
                 ) -> tuple[dict[str, np.ndarray], list[Assumption], list[str]]:
    """The rows that are invalid, by column."""
    invalid = {name: np.zeros(table.row_count, bool) for name in used}
    assumed, notes = [], []
    stated = options.invalid_if
    for condition in likely_conditions(table, used) if stated is None else stated:
        rows = condition_rows(table, condition)
        about = flagged_columns(condition, table.names, used)
        rows &= ~np.logical_and.reduce([invalid[name] for name in about])
        if not about or not np.any(rows):
            continue
        for name in about:
            invalid[name] |= rows
        text = (f"{counted(int(rows.sum()), 'row')} with {condition} "
                f"{'is a gap' if rows.sum() == 1 else 'are gaps'} ({table.where(np.flatnonzero(rows))})")
        report(text, "[source] invalid_if", stated is None, assumed, notes)
    return invalid, assumed, notes


def runs_of_equal(values: np.ndarray) -> list[tuple[int, int]]:
    """[begin, end) of runs of at least three equal values."""
    borders = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1], [True]]))
    lengths = np.diff(borders)
    return [(int(a), int(a + n)) for a, n in zip(borders, lengths) if n >= FEWEST_EQUAL
            and np.isfinite(values[a])]


def digit_of(values: np.ndarray) -> float:
    """The smallest difference between different readings that occurs often."""
    distinct = np.unique(values[np.isfinite(values)])
    return float(np.quantile(np.diff(distinct), 0.05)) if distinct.size > 2 else 0.0


def speed_beside(values: np.ndarray, begin: int, end: int, reach: int) -> float:
    """The smaller of the mean steps just before and just after a run; 0 at an end of the record."""
    def mean_step(part: np.ndarray) -> float:
        steps = np.abs(np.diff(part))
        return float(np.mean(steps[np.isfinite(steps)])) if np.any(np.isfinite(steps)) else 0.0
    before = values[max(0, begin - reach):begin + 1]
    after = values[end - 1:end + reach]
    if before.size < 2 or after.size < 2:
        return 0.0
    return min(mean_step(before), mean_step(after))


def stuck_rows(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows at an end of the range, and rows that keep an earlier value while the stem moves."""
    clipped, frozen = (np.zeros(values.size, bool) for _ in range(2))
    seen = values[np.isfinite(values)]
    if seen.size < 12:
        return clipped, frozen
    ends, digit, half = (seen.min(), seen.max()), digit_of(values), usual_half_swing(values)
    for begin, end in runs_of_equal(values):
        at_end = values[begin] in ends
        if end - begin >= half or (not at_end and end - begin <= FEWEST_EQUAL):
            continue
        if speed_beside(values, begin, end, min(4, end - begin)) < MOVING_DIGITS * digit:
            continue
        if at_end:
            clipped[begin:end] = True
        elif abs(values[end] - values[begin]) > digit if end < values.size else False:
            frozen[begin + 1:end] = True  # the first is a reading
    for value in np.unique(values[clipped]):
        clipped |= values == value  # also where the stem is held or turns beyond the range
    return clipped, frozen


def without_invalid(table: RecordedTable, used: list[str],
                    options: InvalidOptions) -> tuple[dict[str, np.ndarray], list[Assumption], list[str]]:
    """The used columns with gaps for invalid readings; what was assumed, and notes."""
    flagged, assumed, notes = flagged_rows(table, used, options)
    columns = {}
    for name in used:
        values = table.values(table.names.index(name))
        values[flagged[name]] = np.nan
        marks = options.missing_values
        for mark in marks_in(values) if marks is None else marks:
            rows = np.flatnonzero(values == mark)
            values[rows] = np.nan
            if rows.size:
                text = (f'column "{name}": {mark:g} marks {counted(rows.size, "missing reading")} '
                        f"({table.where(rows)})")
                report(text, "[source] missing_values", marks is None, assumed, notes)
        if not options.keeps_stuck:
            for rows, what in zip(stuck_rows(values), ("are the end of the range (clipped?)",
                                                        "repeat while the stem moves")):
                places = np.flatnonzero(rows)
                if places.size:
                    kept = ", ".join(f"{v:g}" for v in np.unique(values[places])[:4])
                    assumed.append(Assumption(
                        f'column "{name}": {counted(places.size, "reading")} {what}: {kept} '
                        f"({table.where(places)}); they are gaps", "[source] stuck_values"))
                    values[places] = np.nan
        columns[name] = values
    return columns, assumed, notes
