# SPDX-License-Identifier: BSD-3-Clause
"""The calibration laws of Schramm et al. (2019), and those of a study from its summary.json."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from culm.archive import Study, StudyError


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
    """A single-predictor law as determined by `culm reduce`."""

    law: Law
    adjusted_r_squared: float


# The residuals of a published law are drawn if nine of ten are smaller than this, in per cent. If
# they are not, the published law does not describe the points, for example under another bond law.
LARGEST_COMPARABLE_RESIDUAL = 20.0
MOST_BINS = 200

# √Y in √Pa from b2 in Hz (Eq. 12), β from b1 per cycle (Eq. 13).
PUBLISHED_YOUNGS_MODULUS = Law(intercept=91.4, slope=574.3)
PUBLISHED_DAMPING = Law(intercept=2.5, slope=-261.4)


def published_laws(study: Study) -> tuple[Law, Law] | tuple[None, None]:
    """Eqs. 12 and 13 if they are those of the study's stem and law, as its summary says."""
    return ((PUBLISHED_YOUNGS_MODULUS, PUBLISHED_DAMPING)
            if study.summary.get("is_published_stem") else (None, None))


def study_law(study: Study, response: str) -> StudyLaw | str:
    """The law of a response ("sqrt_youngs_modulus" or "bond_damping") in summary.json, or the
    reason why the regression was impossible. StudyError if the summary contains neither."""
    try:
        entry = study.summary["regression"][response]
        if "reason" in entry:
            return str(entry["reason"])
        return StudyLaw(
            law=Law(float(entry["intercept"]), float(entry["slope"])),
            adjusted_r_squared=float(entry["adjusted_r2"]),
        )
    except KeyError as missing:
        raise StudyError(
            f"{study.directory / 'summary.json'}: the regression of '{response}' lacks {missing}."
        ) from None
    except (TypeError, ValueError):
        raise StudyError(
            f"{study.directory / 'summary.json'}: the regression of '{response}' is malformed."
        ) from None


def bins_that_hold(edges: np.ndarray, values: np.ndarray) -> np.ndarray | None:
    """The edges, extended at the same width until they enclose every value; None if that takes
    more than MOST_BINS."""
    width = edges[1] - edges[0]
    if np.ptp(np.append(values, edges)) > MOST_BINS * width:
        return None
    below = max(0, int(np.ceil((edges[0] - values.min()) / width)))
    above = max(0, int(np.floor((values.max() - edges[-1]) / width)) + 1)
    return edges[0] + width * np.arange(-below, edges.size + above)


def published_residual_counts(published: Law, predictor, response, edges: np.ndarray):
    """Counts and edges of the residuals of a published law, with bins like `edges`; None if the law
    does not describe the points or the bins are too narrow for it."""
    residuals = published.residuals_percent(predictor, response)
    bins = bins_that_hold(edges, residuals)
    if bins is None or np.quantile(np.abs(residuals), 0.9) > LARGEST_COMPARABLE_RESIDUAL:
        return None
    return np.histogram(residuals, bins)[0], bins
