# SPDX-License-Identifier: BSD-3-Clause
"""The results of calibrate, compare, diagnose and simulate as Python objects.

Every object keeps the complete document that culm wrote as `document` (`culm schema NAME` describes
it) and what culm printed as `text`. Parameters are named as in the document, in SI units.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Estimate:
    """A fitted number with its standard error and 95 % interval; NaN where culm states none."""

    value: float
    standard_error: float
    interval: tuple[float, float]
    unit: str = ""
    at_bound: bool = False

    @classmethod
    def of(cls, found: dict) -> Estimate:
        low, high = found.get("interval") or (None, None)
        return cls(_number(found["value"]), _number(found.get("stderr")),
                   (_number(low), _number(high)), found.get("unit", ""),
                   found.get("at_bound", False))

    def __str__(self):
        half = 0.5 * (self.interval[1] - self.interval[0])
        return f"{self.value:.4g} ± {half:.2g} {self.unit}".rstrip()


def _number(value) -> float:
    return math.nan if value is None else float(value)


def _estimates(found: dict | None) -> dict[str, Estimate]:
    return {name: Estimate.of(entry) for name, entry in (found or {}).items()}


def _columns(parameters: dict[str, Estimate]) -> dict[str, float]:
    """Value and standard error of each parameter, for a row of a table."""
    columns = {}
    for name, estimate in parameters.items():
        columns[name] = estimate.value
        columns[f"{name}.standard_error"] = estimate.standard_error
    return columns


def _frame(rows: list[dict], index: str):
    import pandas
    return pandas.DataFrame(rows).set_index(index)


@dataclass(frozen=True)
class Stem:
    """The calibration of one recording. `failure` says why there is none; else it is empty."""

    name: str
    folder: str
    parameters: dict[str, Estimate]
    rmse_mm: float
    rmse_over_noise: float
    is_adequate: bool
    sentence: str
    failure: str
    document: dict = field(repr=False)


class _Printed:
    """A result that prints as the text that culm printed."""

    text: str

    def __str__(self):
        return self.text


@dataclass(frozen=True)
class Calibration(_Printed):
    """The stems of `culm calibrate`, in its order; calibration[0] is the first."""

    stems: list[Stem]
    document: dict = field(repr=False)
    text: str = field(repr=False)

    @classmethod
    def of(cls, document: dict, text: str) -> Calibration:
        return cls([cls._stem(found) for found in document["stems"]], document, text)

    @staticmethod
    def _stem(found: dict) -> Stem:
        fit = found.get("fit") or {}
        return Stem(found["measurement"], found["folder"], _estimates(found.get("parameters")),
                    _number(fit.get("rmse_mm")), _number(fit.get("rmse_over_noise")),
                    bool(fit.get("adequate")), found.get("sentence", ""),
                    found.get("failure", ""), found)

    def __getitem__(self, index) -> Stem:
        return self.stems[index]

    def __len__(self):
        return len(self.stems)

    def table(self):
        """One row for each stem, a pandas DataFrame."""
        return _frame([{"measurement": stem.name, "is_adequate": stem.is_adequate,
                        "rmse_mm": stem.rmse_mm, "rmse_over_noise": stem.rmse_over_noise,
                        **_columns(stem.parameters)} for stem in self.stems], "measurement")


@dataclass(frozen=True)
class Model:
    """One model of `culm compare`. `failure` says why it could not be fitted; else it is empty."""

    name: str
    effects: list[str]
    parameters: dict[str, Estimate]
    rmse_mm: float
    rmse_over_noise: float
    log_evidence: float
    is_adequate: bool
    reason: str
    failure: str
    document: dict = field(repr=False)


@dataclass(frozen=True)
class Comparison(_Printed):
    """The models of `culm compare`, the published chain first; `best` is the best one."""

    measurement: str
    headline: str
    noise_mm: float
    models: list[Model]
    best: Model
    document: dict = field(repr=False)
    text: str = field(repr=False)

    @classmethod
    def of(cls, document: dict, text: str) -> Comparison:
        models = [cls._model(found) for found in document["ladder"]]
        return cls(document["measurement"], document["headline"], _number(document["noise_mm"]),
                   models, models[document["best"]], document, text)

    @staticmethod
    def _model(found: dict) -> Model:
        verdict = found.get("verdict") or {}
        return Model(" + ".join(found["model"]), list(found["added"]),
                     _estimates(found.get("parameters")), _number(found.get("rmse_mm")),
                     _number(found.get("rmse_over_noise")), _number(found.get("log_evidence")),
                     bool(verdict.get("adequate")), verdict.get("reason", ""),
                     found.get("failure", ""), found)

    def table(self):
        """One row for each model, a pandas DataFrame."""
        return _frame([{"model": model.name, "is_adequate": model.is_adequate,
                        "rmse_mm": model.rmse_mm, "rmse_over_noise": model.rmse_over_noise,
                        "log_evidence": model.log_evidence, **_columns(model.parameters)}
                       for model in self.models], "model")


@dataclass(frozen=True)
class Diagnosis(_Printed):
    """The answer of `culm diagnose` for one stem or for a laboratory.

    `verdict` is "adequate", "effect", "tie" or "unknown"; `effects` are named only with "effect".
    `probability` is that of the explanation, `sentences` are what culm says about it.
    """

    verdict: str
    effects: list[str]
    probability: float
    parameters: dict[str, Estimate]
    sentences: list[str]
    is_laboratory: bool
    document: dict = field(repr=False)
    text: str = field(repr=False)

    @classmethod
    def of(cls, document: dict, text: str) -> Diagnosis:
        is_laboratory = document["format"] == "culm-laboratory"
        effects = [found["effect"] for found in document["rig_effects"]] if is_laboratory \
            else list(document["effects"])
        return cls(document["conclusion" if is_laboratory else "verdict"], effects,
                   _number(document["probability"]), _estimates(document.get("parameters")),
                   list(document["sentences"]), is_laboratory, document, text)

    def models(self):
        """The compared models with log evidence and probability, a pandas DataFrame."""
        return _frame([{"model": " + ".join(["chain", *found["effects"]]),
                        "log_evidence": _number(found.get("log_evidence")),
                        "probability": _number(found.get("probability"))}
                       for found in self.document["models"]], "model")


@dataclass(frozen=True)
class Simulation:
    """b1 and b2 of one simulated stem, fitted by Eq. 1."""

    bond_youngs_modulus_pa: float
    bond_damping: float
    decay_per_cycle: float
    frequency_hz: float
    document: dict = field(repr=False)
