# SPDX-License-Identifier: BSD-3-Clause
"""Histograms of figures and of the report."""
from __future__ import annotations

import numpy as np

MOST_BINS = 40


def histogram_of(values) -> tuple[np.ndarray, np.ndarray]:
    """Counts and edges; the number of bins follows the values (Freedman & Diaconis, Sturges)."""
    values = np.asarray(values, dtype=float)
    known = values[np.isfinite(values)]
    edges = np.histogram_bin_edges(known, bins="auto")
    if edges.size - 1 > MOST_BINS:
        edges = np.histogram_bin_edges(known, bins=MOST_BINS)
    return np.histogram(known, edges)
