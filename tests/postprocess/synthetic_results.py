# SPDX-License-Identifier: BSD-3-Clause
"""Small results of every command except culm run, valid by their schemas in docs/schemas."""
import json
from pathlib import Path

import h5py
import numpy as np

HEIGHTS_MM = (50.0, 100.0, 150.0)
TIME = np.linspace(-0.005, 0.295, 61)
NOISE_MM = 0.04
UNSEEN = (3, 1)  # frame and height without a reading
PARAMETERS = {"bond_youngs_modulus_pa": (2.0e9, 1e6), "bond_damping": (60.0, 0.2),
              "tip_deflection_m": (0.02, 1e-5), "release_time_s": (1e-6, 1e-6)}


def estimate(value, stderr=0.01):
    return {"value": value, "stderr": stderr, "interval": [value - 2 * stderr, value + 2 * stderr]}


def motion(decay, scale=1.0):
    """Deflection (T, H) in mm of a stem that is held and then swings."""
    time = np.maximum(TIME, 0.0)
    swing = scale * 20.0 * np.exp(-decay * time) * np.cos(2 * np.pi * 60.0 * time)
    return swing[:, None] * (np.array(HEIGHTS_MM) / 150.0) ** 2


MEASURED = motion(12.0)
MEASURED[UNSEEN] = np.nan
PREDICTED = {"baseline": motion(9.0), "baseline + quadratic_drag": motion(12.0, 1.001)}


def rows(values):
    """Numbers as written in JSON."""
    return [[None if np.isnan(value) else round(float(value), 6) for value in row]
            for row in values]


def parameters(extra=None):
    table = {**PARAMETERS, **(extra or {})}
    return {name: {**estimate(*pair), "unit": "", "at_bound": False} for name, pair in table.items()}


def group(**place):
    return {"readings": 60, "rms_mm": 0.1, "mean_mm": 0.01, "rms_over_noise": 2.5, **place}


def backbone(*points):
    """Of mode 1, from pairs of amplitude in mm and damping ratio."""
    return [{"mode": 1, "height_mm": 100.0, "is_strain": False, "reason": "", "signature": None,
             "laws": None,
             "points": [{"time_s": 0.04, "amplitude_mm": amplitude, "damping_ratio": ratio,
                         "damping_ratio_stderr": 0.001, "frequency_hz": 80.0,
                         "frequency_stderr_hz": 0.01} for amplitude, ratio in points]}]


def backbone_with_laws():
    """Of mode 1: ζ = 0.001/A + 0.01 + 0.02 A and f = 80 (1 − 0.05 A²), A over 10 mm; and a mode 2
    without laws."""
    known = {"coulomb": 0.001, "linear": 0.01, "power": 0.02, "power_exponent": 1.0,
             "decrement_p": 0.07, "decrement_q": 0.12, "frequency_hz": 80.0, "softening": 0.05,
             "softening_exponent": 2.0}
    first, = backbone(*((amplitude, 0.01 / amplitude + 0.01 + 0.002 * amplitude)
                        for amplitude in (10.0, 5.0, 2.5)))
    for point in first["points"]:
        point["frequency_hz"] = 80.0 * (1.0 - 0.0005 * point["amplitude_mm"] ** 2)
    first |= {"signature": "edges or slip",
              "laws": {"reference_amplitude_mm": 10.0,
                       **{name: estimate(value) for name, value in known.items()}}}
    second, = backbone((0.1, 0.02))
    return [first, second | {"mode": 2, "reason": "fewer than five windows of eight cycles show it"}]


def fit(backbones):
    """fit.json of one stem, of culm fit --backbone."""
    heights = [{"height_mm": height, "b1_per_cycle": estimate(-0.2)} for height in HEIGHTS_MM]
    return {"format": "culm-fit", "version": 1, "population": None, "remarks": [],
            "stems": [{"measurement": "T2", "length_mm": 155.0, "largest_deflection_mm": 20.0,
                       "aspect_ratio": 50.0, "adequate_heights": 3, "heights": heights,
                       "b1_per_cycle": estimate(-0.2), "b2_hz": estimate(80.0),
                       "backbone": backbones}]}


def where(predicted, decay):
    return {
        "by_height": [group(height_mm=height) for height in HEIGHTS_MM],
        "by_time": [group(begin_s=0.1 * k, end_s=0.1 * (k + 1)) for k in range(3)],
        "spectrum": {"frequency_hz": [0.0, 20.0, 40.0, 60.0],
                     "power_over_noise": [1.0, None, 3.0, 40.0], "mode_frequencies_hz": [60.0],
                     "mode_shares": [1.0]},
        "backbone": {"measured": backbone((10.0, 0.03), (3.0, 0.02)),
                     "modelled": backbone((10.0, -decay / 6.3))},
        "banding": {"heights": [{"height_mm": 50.0, "measured": estimate(-0.2),
                                 "modelled": estimate(decay)},
                                {"height_mm": 100.0, "measured": None, "modelled": None}],
                    "measured": None, "modelled": None},
        "residual_map": {"time_s": TIME.tolist(), "height_mm": list(HEIGHTS_MM),
                         "residual_mm": rows(MEASURED - predicted)},
    }


def comparison_rung(names, finding, predicted, decay):
    ratio = 5.0 if finding == "inadequate" else 1.0
    sentence = f"The model is {finding}."
    rung = {
        "model": names, "added": names[1:], "runs": 9, "moves": True,
        "rmse_mm": NOISE_MM * ratio, "rmse_over_noise": ratio, "reduced_chi2": ratio**2,
        "contradicted_inputs": [{"name": "clamp height", "pull": 44.2}] if ratio > 1.0 else [],
        "degrees_of_freedom": 170, "effective_degrees_of_freedom": 120.5,
        "parameters": parameters(), "log_evidence": 2000.0 * (ratio == 1.0), "sentences": [sentence, "And so on."],
        "verdict": {"finding": finding,
                    "adequate": finding == "adequate", "p_value": 0.5,
                    "reason": "", "tests": [{"name": "size", "p_value": 0.5,
                                             "adjusted_p_value": 1.0}]},
        "where": where(predicted, decay), "remarks": [],
    }
    if len(names) > 1:
        rung |= {"compared_with": 0, "gain": True, "why": "the log evidence rises by 2000",
                 "log_evidence_gain": 2000.0,
                 "step": "quadratic_drag improves on the baseline: the log evidence rises by 2000.",
                 "change": {"bond_youngs_modulus": -0.01, "bond_damping": -0.4}}
    return rung


def comparison(name="T2"):
    predicted = list(PREDICTED.values())
    return {
        "format": "culm-comparison", "version": 1, "measurement": name, "folder": f"data/{name}",
        "frames": TIME.size, "heights": len(HEIGHTS_MM), "noise_mm": NOISE_MM,
        "noise_source": "stated", "noise_known": True, "remarks": [],
        "options": {"law": "consistent", "with": "quadratic_drag", "ladder": "", "window_s": None},
        "headline": f"With quadratic_drag the published chain explains {name}.", "best": 1,
        "ladder": [comparison_rung(["baseline"], "inadequate", predicted[0], -0.15),
                   comparison_rung(["baseline", "quadratic_drag"], "adequate", predicted[1], -0.2),
                   {"model": ["baseline", "quadratic_drag", "taper"], "added": ["taper"],
                    "runs": 3, "step": "taper could not be fitted.",
                    "failure": "a taper <of> no use"}],
    }


PROVENANCE = {
    "version": "culm 0.1.0 (abc)", "compiler": "g++ 12.2.0", "build": "Release", "libraries": "none",
    "date": "2026-11-21T23:59:07Z", "command": "culm diagnose T2 -o 'my folder'", "wall_s": 12.5,
    "processor_s": 24.0, "ranks": 2,
    "inputs": [{"file": "T2/stem.toml", "bytes": 155, "crc32": "0123abcd"},
               {"file": "T2/gone.csv", "bytes": None, "crc32": None}]}


def write_deflections(folder):
    """deflections.csv of one recording, the published chain and a better model."""
    tables = {"measured": MEASURED, **PREDICTED}
    head = ["time_s", *(f"{label} h={height:.10g}mm" for height in HEIGHTS_MM for label in tables)]
    lines = [",".join(head)]
    for frame, time in enumerate(TIME):
        cells = [tables[label][frame, row] for row in range(len(HEIGHTS_MM)) for label in tables]
        lines.append(",".join([f"{time:.9g}", *("" if np.isnan(cell) else f"{cell:.9g}"
                                                for cell in cells)]))
    (Path(folder) / "deflections.csv").write_text("\n".join(lines) + "\n", "utf-8")


def write_comparison(folder, name="T2", with_motion=True):
    write(folder, "comparison.json", comparison(name))
    if with_motion:
        write_deflections(folder)


def diagnosis(name="T2", verdict="effect"):
    rung = {"model": ["baseline"], "rmse_mm": 0.2, "reduced_chi2": 25.0, "finding": "inadequate",
            "contradicted_inputs": [{"name": "scale", "pull": -3.1}], "p_value": 0.0,
            "tests": "size", "parameters": parameters()}
    better = {**rung, "model": ["baseline", "quadratic_drag"], "rmse_mm": NOISE_MM,
              "contradicted_inputs": [], "finding": "adequate", "log_evidence": 2000.0}
    named = verdict in ("effect", "tie")
    families = ([{"family": "air", "members": ["quadratic_drag"], "by_family": True}]
                if verdict == "effect" else [])
    force = {"kind": "force_per_length", "form": "(-0.002)*v*abs(v)", "character": "dissipative",
             "terms": [{"term": "v*abs(v)", "coefficient": -0.002, "stderr": 1e-5,
                        "probability": 1.0}],
             "explained": 0.99, "rmse_mm": 0.04, "effect_file": "[effect]\nname = \"missing\"\n",
             "against_displacement": [{"displacement_mm": x, "velocity_m_s": 0.0,
                                       "force_n_per_m": 0.0} for x in (-20.0, 20.0)],
             "against_velocity": [{"displacement_mm": 0.0, "velocity_m_s": v,
                                   "force_n_per_m": -0.002 * v * abs(v)}
                                  for v in (-9.0, 0.0, 9.0)]}
    explanations = [{"effects": ["quadratic_drag"] if named else [], "probability": 0.97},
                    {"effects": ["taper"], "probability": 0.03}]
    spot = {"effect": "taper", "beyond_bounds": False, "bias_if_present": "…",
            "smallest_visible": {"parameter": "relative_change", "value": 0.008, "unit": ""},
            "bias": {"bond_youngs_modulus": -0.015, "bond_damping": None}}
    return {
        "format": "culm-diagnosis", "version": 2, "measurement": name, "noise_mm": NOISE_MM,
        "recordings": [{"id": name, "folder": f"data/{name}", "frames": TIME.size,
                        "heights": len(HEIGHTS_MM), "noise_mm": NOISE_MM,
                        "noise_source": "stated", "noise_known": True}],
        "baseline": {"rmse_mm": 0.2, "reduced_chi2": 25.0, "adequate": verdict == "adequate",
                     "parameters": parameters()},
        "verdict": verdict, "reason": "with it the residuals are noise",
        "sentences": [f"{verdict.upper()}: the verdict.", "Why: with it the residuals are noise."],
        "probability": 0.97, "unexplained_mm": 0.01, "unexplained_share_of_swing": 0.002,
        "alternatives": [{"families": families, "probability": 0.97}],
        "models": [{"effects": ["quadratic_drag"], "log_evidence": 0.0, "probability": 0.97},
                   {"effects": ["relaxation"], "log_evidence": None, "probability": 0.0,
                    "failure": "no"}],
        "explanations": explanations,
        "immaterial": [{"effect": "rolling_shutter", "over_noise": 0.06}],
        "largest_unvisited": {"effects": ["taper"], "log_evidence": -5.5},
        "effects": ["quadratic_drag"] if named else [], "explained": 0.99, "parameters": parameters(),
        "families": families,
        "ladder": [rung, better] if named else [rung],
        "blind_spots": [spot, {"effect": "gravity", "failure": "no"},
                        {**spot, "effect": "camera_tilt", "beyond_bounds": True}],
        "next_experiment": [{"what": "release in a vacuum", "expected_gap": 16.0,
                             "separates": [["baseline"], ["baseline", "quadratic_drag"]]}],
        "where": where(PREDICTED["baseline"], -0.2),
        "missing_force": force if verdict == "unknown" else None,
        "failed": [{"effects": ["relaxation"], "reason": "no"}], "runs": 99, "remarks": [],
        "options": {"law": "consistent", "spheres": None, "window_s": None, "max_effects": 3,
                    "candidates": ["quadratic_drag", "taper"], "known": []},
    }


def uncertainty_budget():
    """A budget in which length and noise each contribute half of every variance."""
    known = {key: estimate(*pair) for key, pair in PARAMETERS.items()}
    half = {key: 0.5**0.5 * each["stderr"] for key, each in known.items()}
    return {"inputs": [{"name": "length", "unit": "m", "value": 0.156,
                        "standard_uncertainty": 3e-4, "default": True, "pull": 0.2,
                        "uncertainty_with_readings": 2.9e-4,
                        "sensitivities": {key: part / 3e-4 for key, part in half.items()},
                        "shares": dict.fromkeys(known, 0.5)}],
            "readings": {"standard_uncertainties": half, "shares": dict.fromkeys(known, 0.5)},
            "combined": {key: each["stderr"] for key, each in known.items()},
            "sentences": ["No uncertainty is stated for length: the default is used."]}


def calibrated(name, adequate=True):
    return {
        "measurement": name, "folder": f"data/{name}",
        "stem": "157 mm, 2.83 mm, 82.3 mg (0.524 g/m), EI 0.0063 N m² at Y = 2 GPa, beam theory b2 = "
                "78.7 Hz",
        "sentence": f"{name}: Y = 2.0 GPa; the model is {'' if adequate else 'in'}adequate.",
        "parameters": {key: estimate(*pair) | {"unit": "", "at_bound": False}
                       for key, pair in PARAMETERS.items()},
        "uncertainty_budget": uncertainty_budget(),
        "correlation": {"names": list(PARAMETERS), "matrix": np.eye(4).tolist()},
        "mode": {"b2_hz": estimate(60.0), "b1_per_cycle": estimate(-0.2),
                 "natural_frequency_hz": 60.0, "damping_ratio": 0.03, "damping_time_s": 1e-4},
        "fit": {"rmse_mm": 0.05, "noise_mm": NOISE_MM, "noise_source": "stated",
                "rmse_over_noise": 1.2, "reduced_chi2": 1.1, "contradicted_inputs": [],
                "degrees_of_freedom": 170, "readings": 180, "runs": 12,
                "adequate": adequate, "reason": "", "failed_tests": [] if adequate else ["size"],
                "tests": [{"name": "size", "p_value": 1e-9, "adjusted_p_value": 2e-9}]},
        "chain": {"law": "consistent", "bond_youngs_modulus_pa": 1e9, "bond_damping": 1.0,
                  "spheres": 56, "bond_length_m": 0.003,
                  "sphere_diameter_m": 0.003, "sphere_density_kg_m3": 125.0,
                  "tip_mass_share": 0.5, "bond_outer_diameter_m": 0.003,
                  "bond_inner_diameter_m": 0.0, "poissons_ratio": 0.3, "added_masses": [],
                  "effects": []},
        "remarks": ["a remark"],
    }


def sample(mean, deviation):
    """Two values about the mean."""
    ends = [mean - deviation, mean + deviation]
    return {"count": 2, "mean": mean, "mean_interval": ends, "standard_deviation": deviation,
            "standard_deviation_interval": [0.5 * deviation, 3.0 * deviation], "lowest": ends[0],
            "median": mean, "highest": ends[1], "central_90_percent": ends}


def calibration(names=("S1", "S2")):
    spread = sample(1.0, 0.1)
    population = {"stems": len(names), "failed": 1, "something_missing": 0,
                  **{key: spread for key in ("bond_youngs_modulus_pa", "bond_damping",
                                             "b1_per_cycle", "b2_hz")}}
    return {"format": "culm-calibration", "version": 1, "remarks": [],
            "options": {"law": "consistent", "with": "", "window_s": None},
            "stems": [calibrated(name) for name in names] +
                     [{"measurement": "broken", "folder": "data/broken", "failure": "no motion"}],
            "shared_effects": [], "population": population if len(names) > 1 else None}


def write_calibration(folder, names=("S1", "S2")):
    write(folder, "calibration.json", calibration(names))
    predictions = Path(folder) / "predictions"
    predictions.mkdir()
    predicted = PREDICTED["baseline + quadratic_drag"]
    head = ",".join(f"measured h={h:g}mm,predicted h={h:g}mm" for h in HEIGHTS_MM)
    for number in range(1, len(names) + 1):
        lines = [f"time_s,{head}"]
        for time, seen, modelled in zip(TIME, MEASURED, predicted):
            cells = [f"{'' if np.isnan(a) else a},{b}" for a, b in zip(seen, modelled)]
            lines.append(f"{time},{','.join(cells)}")
        (predictions / f"{number:03}.csv").write_text("\n".join(lines) + "\n", "utf-8")


def write(folder, name, document):
    (Path(folder) / name).write_text(json.dumps(document), encoding="utf-8")
