# SPDX-License-Identifier: BSD-3-Clause
"""Reads times of day, with or without a date: 10:11:12.345, 2026-11-20T10:11:12.345Z."""
from __future__ import annotations

import datetime
import re
from fractions import Fraction

CLOCK = re.compile(r"(?:(\d{4})[-/.](\d\d?)[-/.](\d\d?)[T ]+)?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)Z?")
FIRST_DAY = datetime.date(1970, 1, 1).toordinal()


def clock_seconds(texts: list[str]) -> list[Fraction] | None:
    """Seconds of times of day, with or without a date; None if a cell is neither. Midnight between
    two rows is a day later."""
    found, day = [], 0
    for text in texts:
        match = CLOCK.fullmatch(text.strip())
        if match is None:
            return None
        if match[1]:
            day = datetime.date(int(match[1]), int(match[2]), int(match[3])).toordinal() - FIRST_DAY
        second = (Fraction(86400 * day + 3600 * int(match[4]) + 60 * int(match[5]))
                  + Fraction(match[6].replace(",", ".")))
        if not match[1] and found and second < found[-1] - 43200:
            day += 1
            second += 86400
        found.append(second)
    return found
