# SPDX-License-Identifier: BSD-3-Clause
"""The laws that read a stem: of Schramm et al. (2019), and of a study from its summary.json."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from culm_archive import Study, StudyError


@dataclass(frozen=True)
class Law:
    """response = intercept + slope · predictor."""

    intercept: float
    slope: float

    def __call__(self, predictor):
        return self.intercept + self.slope * predictor

    def residuals_percent(self, predictor, response) -> np.ndarray:
        """Observed − fitted in per cent of the largest observed response, as in Fig. 8; (M)."""
        return 100.0 * (response - self(predictor)) / np.max(np.abs(response))


@dataclass(frozen=True)
class StudyLaw:
    """A single-predictor law as `culm reduce` found it."""

    law: Law
    adjusted_r_squared: float
    residual_edges: np.ndarray  # (bins + 1), per cent
    residual_counts: np.ndarray  # (bins)


# √Y in √Pa from b2 in Hz (Eq. 12), β from b1 per cycle (Eq. 13).
PUBLISHED_YOUNGS_MODULUS = Law(intercept=91.4, slope=574.3)
PUBLISHED_DAMPING = Law(intercept=2.5, slope=-261.4)


def study_law(study: Study, response: str) -> StudyLaw | str:
    """The law of a response ("sqrt_youngs_modulus" or "bond_damping") in summary.json, or the
    reason why the regression was impossible. StudyError if the summary holds neither."""
    try:
        entry = study.summary["regression"][response]
        if "reason" in entry:
            return str(entry["reason"])
        histogram = entry["residuals_percent"]
        law = StudyLaw(
            law=Law(float(entry["intercept"]), float(entry["slope"])),
            adjusted_r_squared=float(entry["adjusted_r2"]),
            residual_edges=np.asarray(histogram["edges"], dtype=float),
            residual_counts=np.asarray(histogram["counts"], dtype=int),
        )
    except KeyError as missing:
        raise StudyError(
            f"{study.directory / 'summary.json'}: the regression of '{response}' lacks {missing}."
        ) from None
    except (TypeError, ValueError):
        raise StudyError(
            f"{study.directory / 'summary.json'}: the regression of '{response}' is malformed."
        ) from None
    bins = law.residual_counts.size
    if bins == 0 or law.residual_edges.shape != (bins + 1,):
        raise StudyError(
            f"{study.directory / 'summary.json'}: the residual histogram of '{response}' must have "
            "one edge more than counts."
        )
    return law
