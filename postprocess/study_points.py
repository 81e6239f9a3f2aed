# SPDX-License-Identifier: BSD-3-Clause
"""The points of a study that the figures and the regressions use."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from culm.archive import Study, StudyError

YOUNGS_MODULUS_KEY = "bond_youngs_modulus_gpa"
DAMPING_KEY = "bond_damping"


@dataclass(frozen=True)
class StudyPoints:
    """Completed points whose numbers are finite; M of them, every array (M)."""

    id: np.ndarray
    youngs_modulus: np.ndarray  # Y, Pa
    damping: np.ndarray  # β
    decay_per_cycle: np.ndarray  # b1 in normalised time, negative for a motion that dies away
    frequency: np.ndarray  # b2, Hz


def fitted_points(study: Study) -> StudyPoints:
    """The points that have a fit of Eq. 1; StudyError if there is none or a column is missing."""
    columns = {
        "youngs_modulus": 1e9 * study.parameter(YOUNGS_MODULUS_KEY),
        "damping": study.parameter(DAMPING_KEY),
        "decay_per_cycle": study["decay_per_cycle"],
        "frequency": study["frequency"],
    }
    is_usable = study.is_completed & np.all(np.isfinite(list(columns.values())), axis=0)
    if not is_usable.any():
        raise StudyError(f"{study.path}: no point was completed with a fit of Eq. 1.")
    return StudyPoints(
        id=np.flatnonzero(is_usable),
        **{name: values[is_usable] for name, values in columns.items()},
    )


def conditions(study: Study) -> str:
    """The settings besides Y and β that affect a figure: bond law, fit window, other factors."""
    settings = study.settings
    texts = []
    if "law.name" in settings:
        texts.append(f"law {settings['law.name']}")
    if "reduce.window_s" in settings:
        texts.append(f"fit window {settings['reduce.window_s']} s")
    others = other_factors(study)
    if others:
        texts.append(f"also varied: {', '.join(others)}")
    return "; ".join(texts)


def other_factors(study: Study) -> list[str]:
    """Factors that vary besides Y and β."""
    known = (YOUNGS_MODULUS_KEY, DAMPING_KEY)
    return [
        name
        for name, values in study.factors.items()
        if name not in known and np.ptp(values) > 0.0
    ]


def fit_window(study: Study) -> float:
    """Time from the release to which Eq. 1 was fitted, s."""
    try:
        return float(study.settings["reduce.window_s"])
    except KeyError:
        return float(study.time[-1])


def fitted_motion(study: Study, point: int, time: np.ndarray, tip: np.ndarray) -> np.ndarray:
    """Eq. 1 at the times, m; (S). b0 is stored relative to the largest deflection in the window."""
    in_window = (time >= 0.0) & (time <= fit_window(study))
    scale = np.max(np.abs(tip[in_window]))
    envelope = study["amplitude"][point] * scale * np.exp(study["decay_rate"][point] * time)
    return envelope * np.cos(2.0 * np.pi * study["frequency"][point] * time)
