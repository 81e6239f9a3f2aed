#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Every effect of the library, and one pair, in a fit to each of the seven recordings whose truth is
known: effect_matrix.py BUILD. Prints Markdown tables.

The residuals are over the stated noise, with chains of 20 spheres: "b" marks a parameter at its
bound, "-" a model that could not be fitted.
"""
import json
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

DATA = Path(__file__).resolve().parents[1] / "tests" / "data"
FOLDERS = (DATA / "measurements" / "T1-null", *sorted((DATA / "hidden-effect").glob("T*")))
PAIR = "clamp_compliance,quadratic_drag"
# What the recordings hide (README.md in their folder): parameter, value, unit.
TRUTH = {
    "T2": ("quadratic_drag", (("drag_coefficient", 1.3, ""),)),
    "T3": ("clamp_compliance", (("stiffness_nm_rad", 0.6696, "N m/rad"),)),
    "T4": ("bending_nonlinearity", (("gamma_m2", -0.012, "m²"),)),
    "T5": ("relaxation", (("fraction", 0.03, ""), ("time_s", 0.15, "s"))),
    "T6": ("clamp_friction", (("moment_nm", 3e-4, "N m"), ("stiffness_nm_rad", 0.799, "N m/rad"))),
    "T7": (PAIR, (("drag_coefficient", 1.2, ""), ("stiffness_nm_rad", 0.6782, "N m/rad"))),
}
FIXED = {"relaxation": "relaxation(hold_time_s=3)",  # T5's stem was held for 3 s
         "fractional_zener": "fractional_zener(hold_time_s=3)"}


def library(culm: Path) -> list[str]:
    printed = subprocess.run([culm, "effects"], text=True, capture_output=True, check=True).stdout
    return re.findall(r"^(\w+) {2,}", printed, re.M)


def ladder(culm: Path, folder: Path, effects: str) -> list[dict]:
    """The models of `culm compare`; only the baseline if the other could not be fitted."""
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        command = [culm, "compare", folder, "--spheres", "20", "--quiet", "--json", file.name]
        if effects:
            command += ["--with", ",".join(FIXED.get(name, name) for name in effects.split(","))]
        subprocess.run(command, capture_output=True, check=False)
        found = json.loads(Path(file.name).read_text("utf-8"))["ladder"]
    return [model for model in found if "rmse_over_noise" in model]


def cell(models: list[dict], wanted: int) -> str:
    if len(models) < wanted:
        return "-"
    model = models[-1]
    at_bound = any(each["at_bound"] for name, each in model["parameters"].items() if "." in name)
    return f"{model['rmse_over_noise']:.2f}{'b' if at_bound else ''}"


def found_rows(answers: dict) -> list[tuple]:
    rows = []
    for folder in FOLDERS[1:]:
        name = folder.name[:2]
        effects, truths = TRUTH[name]
        models = answers[folder, effects]
        for parameter, truth, unit in truths:
            value = next(each for key, each in models[-1]["parameters"].items()
                         if key.endswith(f".{parameter}"))
            low, high = value["interval"]
            rows.append((name, effects.replace(",", ", "), f"{models[0]['rmse_over_noise']:.2f}",
                         f"{models[-1]['rmse_over_noise']:.2f}", parameter,
                         f"{value['value']:.4g} ({low:.4g} … {high:.4g}) {unit}".strip(),
                         f"{truth:g} {unit}".strip()))
    return rows


def print_table(title: str, header: tuple, rows: list[tuple]):
    print(f"{title}\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")
    print()


def main(build: Path):
    culm = build / "src" / "cli" / "culm"
    effects = ["", *library(culm), PAIR]
    wanted = [(folder, each) for folder in FOLDERS for each in effects]
    with ThreadPoolExecutor(2) as workers:
        answers = dict(zip(wanted, workers.map(lambda key: ladder(culm, *key), wanted)))
    print_table("Found", ("recording", "effect", "residual/noise without", "with", "parameter",
                          "value (95 %)", "truth"), found_rows(answers))
    print_table("Matrix", ("effect", *(folder.name[:2] for folder in FOLDERS)),
                [(each or "none", *(cell(answers[folder, each], 1 + bool(each))
                                    for folder in FOLDERS)) for each in effects])


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
