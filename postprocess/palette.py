# SPDX-License-Identifier: BSD-3-Clause
"""Colours that colour-blind readers can distinguish, and the format of numbers; draws nothing."""
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
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 4) -> str:
    """A number with `digits` significant digits, a true minus sign and a power of ten for many zeros."""
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    if exponent:
        power = "10" + str(int(exponent)).translate(SUPERSCRIPTS)
        mantissa = power if mantissa == "1" else f"{mantissa}·{power}"
    return mantissa.replace("-", "\N{MINUS SIGN}")
