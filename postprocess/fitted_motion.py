# SPDX-License-Identifier: BSD-3-Clause
"""Eq. 1 as it was fitted to a point of a study, from the numbers in the archive."""
from __future__ import annotations

import numpy as np

from culm_archive import Study


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
