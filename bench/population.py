#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""29 synthetic stems whose truth is known, by Eq. 1 and by the chain: population.py BUILD DATA.

DATA holds lab-population, which is not part of the repository. Every stem has a mildly yielding
clamp (k L/(E I) 120 to 1200) that the fitted models do not have. Prints Markdown tables.
"""
import csv
import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path


def answer(culm: Path, *arguments) -> dict:
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        subprocess.run([culm, *arguments, "--json", file.name], capture_output=True, check=False)
        return json.loads(Path(file.name).read_text("utf-8"))


def sample(population: dict, key: str, sign: int = 1) -> str:
    found = population[key]
    return f"{sign * found['mean']:.4g} ({found['standard_deviation']:.3g})"


def largest(errors: list[float]) -> str:
    return f"{100 * min(errors, key=abs):+.3g} … {100 * max(errors, key=abs):+.3g}"


def print_table(title: str, header: tuple, rows: list[tuple]):
    print(f"{title}\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")
    print()


def print_single_modes(truth: dict, plain: dict, free: dict):
    true_frequency = [float(each["frequency_hz"]) for each in truth.values()]
    true_decay = [float(each["decay_per_cycle"]) for each in truth.values()]
    of_truth = [f"{statistics.mean(values):.4g} ({statistics.stdev(values):.3g})"
                for values in (true_frequency, true_decay)]
    both = plain["population"], free["population"]
    print_table("Eq. 1", ("mean (standard deviation)", "truth", "phase of Eq. 1", "phase free"), [
        ("undamped frequency, Hz", of_truth[0],
         *(sample(each, "natural_frequency_hz") for each in both)),
        ("decay per cycle", of_truth[1], *(sample(each, "b1_per_cycle", -1) for each in both))])
    banding = free["population"]["b1_against_aspect_ratio"]
    print(f"Correlation of b1 with the aspect ratio: {banding['correlation']:.2f} "
          f"(p = {banding['p_value']:.2f}).")
    slope = free["population"]["banding"]
    print(f"Within stems b1 changes by {slope['slopes']['mean']:.4f} over the height "
          f"({slope['slopes']['mean_interval'][0]:.4f} … {slope['slopes']['mean_interval'][1]:.4f}); "
          f"{slope['significant_stems']} of {free['population']['stems']} stems are significant.")


def print_chains(truth: dict, calibration: dict):
    rows = {name: [] for name in ("frequency", "decay per cycle", "Y")}
    inadequate = []
    for stem in calibration["stems"]:
        of_stem = truth[stem["measurement"]]
        mode = stem["mode"]
        rows["frequency"].append(mode["natural_frequency_hz"] / float(of_stem["frequency_hz"]) - 1)
        decay = 2 * math.pi * mode["damping_ratio"]
        rows["decay per cycle"].append(decay / float(of_stem["decay_per_cycle"]) - 1)
        modulus = stem["parameters"]["bond_youngs_modulus_pa"]["value"]
        rows["Y"].append(modulus / (1e9 * float(of_stem["Y_gpa"])) - 1)
        if not stem["fit"]["adequate"]:
            inadequate.append(float(of_stem["clamp_kL_over_EI"]))
    print_table("Chain", ("of the calibrated chain", "stems", "error, %: smallest … largest"),
                [(name, str(len(errors)), largest(errors)) for name, errors in rows.items()])
    stiffness = ", ".join(f"{each:.0f}" for each in sorted(inadequate))
    print(f"Inadequate: {len(inadequate)} of {len(calibration['stems'])} stems"
          + (f", with kL/EI of {stiffness}." if inadequate else "."))


def main(build: Path, data: Path):
    culm, stems = build / "src" / "cli" / "culm", data / "lab-population"
    with open(stems / "population_truth.csv", newline="", encoding="utf-8") as lines:
        truth = {row["id"]: row for row in csv.DictReader(lines)}
    print_single_modes(truth, answer(culm, "fit", stems), answer(culm, "fit", stems, "--phase", "free"))
    print_chains(truth, answer(culm, "calibrate", stems, "--quiet"))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
