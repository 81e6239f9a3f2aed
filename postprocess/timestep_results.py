# SPDX-License-Identifier: BSD-3-Clause
"""The numbers of a time-step study: stable limits, errors below them, and the law of the limit."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from culm.archive import Study, StudyError
from study_points import DAMPING_KEY


@dataclass(frozen=True)
class Limits:
    """Largest stable steps of the completed points, M of them; s."""

    damping: np.ndarray
    bond_time: np.ndarray  # √(m/k_n)
    bisected: np.ndarray
    linearised: np.ndarray
    rule: np.ndarray


@dataclass(frozen=True)
class Errors:
    """Relative errors of the completed points over F fractions of the limit, NaN where unknown."""

    fractions: np.ndarray  # (M, F), steps as taken over the linearised limit
    decay: np.ndarray  # (M, F)
    frequency: np.ndarray  # (M, F)


def is_timestep_study(study: Study) -> bool:
    return study.settings.get("study.kind") == "timestep"


def limits_of(study: Study) -> Limits:
    """StudyError if no point was completed."""
    done = study.is_completed
    if not done.any():
        raise StudyError(f"{study.path}: no point was completed.")
    of = {name: study[name][done] for name in study.result_names if name.startswith("limit_")}
    return Limits(
        damping=study.parameter(DAMPING_KEY)[done],
        bond_time=study["bond_time"][done],
        bisected=0.5 * (of["limit_stable"] + of["limit_unstable"]),
        linearised=np.minimum(of["limit_transverse"], of["limit_axial"]),
        rule=of["limit_rule"],
    )


def fraction_names(study: Study) -> list[str]:
    """The fractions in the names of the columns, as written there and in their order."""
    start = "timestep_at_"
    return [name.removeprefix(start) for name in study.result_names if name.startswith(start)]


def extrapolated_to_zero(steps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Extrapolates each row to step zero as `culm reduce` does: by a parabola (line) through the
    three (two) smallest steps with a value, else NaN. Shapes (M, F); returns (M)."""
    found = np.full(len(steps), np.nan)
    for row, (h, y) in enumerate(zip(steps, values)):
        known = np.isfinite(y)
        order = np.argsort(h[known])[:3]
        h, y = h[known][order], y[known][order]
        if h.size < 2:
            continue
        weights = [np.prod(np.delete(h, k) / (np.delete(h, k) - h[k])) for k in range(h.size)]
        found[row] = y[0] + np.dot(weights, y - y[0])
    return found


def errors_of(study: Study, limits: Limits) -> Errors | None:
    """None if the study compared no steps."""
    names = fraction_names(study)
    if not names:
        return None
    done = study.is_completed

    def table(quantity):
        return np.column_stack([study[f"{quantity}_at_{name}"][done] for name in names])

    steps = table("timestep")

    def relative_error(quantity):
        values = table(quantity)
        return values / extrapolated_to_zero(steps, values)[:, None] - 1.0

    return Errors(
        fractions=steps / limits.linearised[:, None],
        decay=relative_error("decay_per_cycle"),
        frequency=relative_error("frequency"),
    )


def fitted_law(study: Study) -> tuple[float, float] | None:
    """A and B of (τ/Δt)² = A + B β (τ/Δt) from summary.json; None if they are undetermined."""
    try:
        entry = study.summary["regression"]["damped_oscillator"]
        if "reason" in entry:
            return None
        by_name = {c["term"]: float(c["coefficient"]) for c in entry["coefficients"]}
        return by_name["A"], by_name["B"]
    except (KeyError, TypeError, ValueError) as fault:
        raise StudyError(
            f"{study.directory / 'summary.json'}: the law of the time step is malformed: {fault}."
        ) from None


def law_of(coefficients: tuple[float, float], damping: np.ndarray) -> np.ndarray:
    """Δt/τ."""
    a, b = coefficients
    return 2.0 / (b * damping + np.sqrt((b * damping) ** 2 + 4.0 * a))
