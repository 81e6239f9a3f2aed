# SPDX-License-Identifier: BSD-3-Clause
"""Checks the rate of a recording: the swing's frequency and the stated stem give a Young's modulus by
beam theory, E = μ (2π f L²/3.516)² / I, which a wrong unit of time makes absurd."""
from __future__ import annotations

import math

import numpy as np

from recording.columns import usual_half_swing
from recording.mapping_file import Mapping
from recording.measured_rows import Measured
from recording.time_stamps import UNITS

LOWEST, HIGHEST = 1e4, 1e12  # Pa
FIRST_MODE = 3.5160  # (kL)² of a clamped-free beam
FEWEST_SAMPLES_PER_CYCLE = 4.0


def metres(table: dict, name: str) -> float | None:
    value = table.get(f"{name}_mm")
    return 1e-3 * value if value is not None else table.get(f"{name}_m")


def section_of(document: dict) -> tuple[float, float, float] | None:
    """Area and second moment, m² and m⁴, and the area over which density_kg_m3 counts."""
    stem, section = document.get("stem", {}), document.get("section")
    if section is None:
        diameter, wall = metres(stem, "diameter"), metres(stem, "wall")
        if diameter is None:
            return None
        inner = diameter - 2.0 * wall if wall else 0.0
        # A round stem is a chain of touching spheres of this density.
        return (math.pi * (diameter ** 2 - inner ** 2) / 4.0,
                math.pi * (diameter ** 4 - inner ** 4) / 64.0, math.pi * diameter ** 2 / 6.0)
    width, height = metres(section, "width"), metres(section, "height")
    if width is None or height is None:
        return None
    return width * height, width * height ** 3 / 12.0, width * height


def line_density_and_inertia(document: dict) -> tuple[float, float] | None:
    """Mass per length, kg/m, and second moment, m⁴; None if the mapping does not give both."""
    stem, section = document.get("stem", {}), section_of(document)
    length = metres(stem, "length")
    if section is None or length is None:
        return None
    area, inertia, density_area = section
    per_unit = {"density_kg_m3": density_area, "material_density_kg_m3": area,
                "linear_density_kg_m": 1.0, "mass_mg": 1e-6 / length, "mass_kg": 1.0 / length}
    return next(((stem[key] * factor, inertia) for key, factor in per_unit.items() if key in stem),
                None)


def frequency_of(measured: Measured) -> tuple[float, float]:
    """The swing's frequency, Hz, and samples per cycle, from the second half of the largest row."""
    row = max(measured.rows, key=lambda row: row.millimetres)
    begin = int(np.searchsorted(measured.times, 0.0))
    begin += (len(measured.times) - begin) // 8
    half = usual_half_swing(row.values[begin:])
    step = float(np.median(np.diff(measured.times)))
    return 0.5 / (half * step), 2.0 * half


def modulus_note(measured: Measured, mapping: Mapping) -> str | None:
    """A doubt about the rate or the stem, with the unit of time that would be plausible."""
    frequency, samples = frequency_of(measured)
    found = line_density_and_inertia(mapping.document)
    length = metres(mapping.stem, "length")
    if samples < FEWEST_SAMPLES_PER_CYCLE:
        return (f"the swing of {frequency:.4g} Hz has {samples:.2g} samples a cycle: it is too fast "
                "for this rate, or the rate is wrong")
    if found is None or length is None:
        return None
    modulus = found[0] * (2.0 * math.pi * frequency * length ** 2 / FIRST_MODE) ** 2 / found[1]
    if LOWEST <= modulus <= HIGHEST:
        return None
    better = [unit for unit in ("s", "ms", "us", "ns")
              if mapping.time_unit in UNITS and not mapping.has_markers and not mapping.rate_hz
              and LOWEST <= modulus * float(UNITS[mapping.time_unit] / UNITS[unit]) ** 2 <= HIGHEST]
    remedy = (f'with [time] unit = "{better[0]}" it would be plausible' if better else
              "check the rate, the lengths and the density")
    return (f"the swing has {frequency:.4g} Hz, for which beam theory gives Y = {modulus:.2g} Pa; "
            f"{LOWEST:g} to {HIGHEST:g} Pa is plausible: {remedy}")
