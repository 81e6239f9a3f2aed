# SPDX-License-Identifier: BSD-3-Clause
"""Reads times of day, with or without a date: 10:11:12.345, 2026-11-20T10:11:12.345Z,
20.11.2026 10:11:12,345, 11/20/2026 10:11:12.345 PM.

Trap: 3/5/2026 is in March or in May. Only a change of the date matters, which is the next day."""
from __future__ import annotations

import datetime
import re
from fractions import Fraction

CLOCK = re.compile(r"(?:(\d{1,4})[-/.](\d\d?)[-/.](\d{2,4})[T, ]+)?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)"
                   r"(?: ?([AP])M|Z)?", re.IGNORECASE)
FIRST_DAY = datetime.date(1970, 1, 1).toordinal()


def clock_seconds(texts: list[str]) -> list[Fraction] | None:
    """Seconds of times of day, with or without a date; None if a cell is neither. Midnight between
    two rows is a day later."""
    found, day = [], 0
    for text in texts:
        match = CLOCK.fullmatch(text.strip())
        if match is None:
            return None
        first, month, last, hour, minute, second, half = match.groups()
        is_sorted = first is not None and len(first) == 4  # year, month, day
        if is_sorted:
            day = datetime.date(int(first), int(month), int(last)).toordinal() - FIRST_DAY
        hour = int(hour) % 12 + 12 * (half.upper() == "P") if half else int(hour)
        second = (Fraction(86400 * day + 3600 * hour + 60 * int(minute))
                  + Fraction(second.replace(",", ".")))
        if not is_sorted and found and second < found[-1] - 43200:
            day += 1
            second += 86400
        found.append(second)
    return found
