# SPDX-License-Identifier: BSD-3-Clause
"""The measured and modelled motion in comparison.h5 and diagnosis.h5."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np


@dataclass
class Motion:
    """Deflections of one recording, mm."""

    time_s: np.ndarray  # (T)
    heights_mm: np.ndarray  # (H)
    measured_mm: np.ndarray  # (T, H); NaN where nothing was seen
    models: list  # (name, predicted (T, H)), the published chain first


def read_motion(file: Path, group: str = "/") -> Motion | None:
    """None if the file or the group is not there, or cannot be read."""
    try:
        with h5py.File(file, "r") as content:
            place = content[group]
            names = sorted((name for name in place if name.startswith("model_")),
                           key=lambda name: int(name.removeprefix("model_")))
            return Motion(place["time"][()], 1e3 * place["height"][()], 1e3 * place["measured"][()],
                          [(str(place[name].attrs["model"]), 1e3 * place[name]["predicted"][()])
                           for name in names])
    except (OSError, KeyError):
        return None
