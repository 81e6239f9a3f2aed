# SPDX-License-Identifier: BSD-3-Clause
"""Backbones in the JSON of fit, compare and diagnose (docs/backbone.md): points, laws, labels.

Figures and report share this file; it imports no library that draws.
"""
from __future__ import annotations

import numpy as np

from command_results import numbers
from palette import number

# Member of a point, its standard error, label.
QUANTITIES = (("frequency_hz", "frequency_stderr_hz", "frequency, Hz"),
              ("damping_ratio", "damping_ratio_stderr", "damping ratio"))
LAW_POINTS = 60

# As in src/reduce/backbone/amplitude_laws.cpp.
SENTENCES = {
    "linear": "Neither damping ratio nor frequency depends on the amplitude: losses are linear "
              "(material, still air, clamp), and masses, stiffness and clamp show in the frequency "
              "alone.",
    "friction": "The damping ratio falls with the amplitude, as with dry friction in the clamp or "
                "at a cable.",
    "drag": "The damping ratio grows with the amplitude and the frequency stays, as with drag of "
            "the air or a material whose loss grows with the strain.",
    "edges or slip": "The damping ratio grows and the frequency falls with the amplitude, as with "
                     "the air at the edges of a plate or a joint that slips.",
    "stiffness": "The frequency changes with the amplitude and the damping ratio stays, as with a "
                 "bending stiffness that is not constant or a large swing.",
    "beat": "The amplitude does not fall steadily, as with two planes of bending, two close modes "
            "or a moving support.",
}


def points_of(backbones: list[dict]) -> list[dict]:
    """The points of mode 1."""
    return backbones[0]["points"] if backbones else []


def column(points: list[dict], key: str) -> list[float]:
    return numbers([point[key] for point in points])


def unit_of(backbone: dict) -> str:
    return "mm/m" if backbone["is_strain"] else "mm"


def amplitude_label(backbone: dict) -> str:
    return f"amplitude, {unit_of(backbone)}"


def draw_points(axes, points: list[dict], key: str, error: str | None, **style):
    """The number `key` against the amplitude; `error`: key of its standard error."""
    if points:
        axes.errorbar(column(points, "amplitude_mm"), column(points, key),
                      yerr=[1.96 * value for value in column(points, error)] if error else None,
                      **style)


def law_curve(backbone: dict, key: str) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes from the smallest to the largest of the points, and the fitted law at them."""
    laws = backbone["laws"]
    known = column(backbone["points"], "amplitude_mm")
    amplitudes = np.geomspace(min(known), max(known), LAW_POINTS)
    relative = amplitudes / laws["reference_amplitude_mm"]

    def term(name: str, power) -> np.ndarray:
        entry = laws[name]
        return np.zeros(LAW_POINTS) if entry is None else entry["value"] * relative**power

    def exponent(name: str) -> float:
        return laws[name]["value"] if laws[name] else 1.0

    if key == "damping_ratio":
        return amplitudes, (term("coulomb", -1.0) + term("linear", 0.0)
                            + term("power", exponent("power_exponent")))
    return amplitudes, laws["frequency_hz"]["value"] * (
        1.0 - term("softening", exponent("softening_exponent")))


def law_text(laws: dict, key: str) -> str:
    """The terms that the law has: "c/A + ζ0", "f0 (1 − ε A^q), q = 0.67"."""
    if key == "damping_ratio":
        terms = ["c/A"] if laws["coulomb"] else []
        terms.append("ζ0")
        if laws["power"]:
            terms.append(f"ζ1 A^p, p = {number(laws['power_exponent']['value'], 3)}")
        return " + ".join(terms)
    if laws["softening"]:
        return ("f0 (1 \N{MINUS SIGN} ε A^q), q = "
                f"{number(laws['softening_exponent']['value'], 3)}")
    return "f0"
