# SPDX-License-Identifier: BSD-3-Clause
"""Colours that colour-blind readers can tell apart, and how numbers are written; draws nothing."""
from __future__ import annotations

# Okabe & Ito (2008), Color Universal Design.
BLUE = "#0072B2"
ORANGE = "#E69F00"
GREEN = "#009E73"
VERMILLION = "#D55E00"
BLACK = "#000000"
GREY = "#BBBBBB"
SERIES = (BLUE, VERMILLION, GREEN)
COLOUR_MAP = "viridis"


def number(value: float, digits: int = 4) -> str:
    """A number with so many significant digits and a true minus sign."""
    return f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")
