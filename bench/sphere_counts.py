#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Calibrations of one recording with chains of 28 to 224 spheres: sphere_counts.py BUILD.

The recording is of a continuum without spheres (tests/data/measurements/README.md): 2.4 GPa, 0.26
per cycle. Prints a Markdown table.
"""
import json
import math
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TRUE_MODULUS, TRUE_DECAY = 2.4e9, 0.26


def row(culm: Path, spheres: int) -> tuple:
    printed = subprocess.run(
        [culm, "calibrate", ROOT / "tests" / "data" / "measurements" / "T1-null", "--spheres",
         str(spheres), "--quiet", "--json", "-"], text=True, capture_output=True, check=True).stdout
    stem = json.loads(printed)["stems"][0]
    modulus = stem["parameters"]["bond_youngs_modulus_pa"]["value"]
    decay = 2 * math.pi * stem["mode"]["damping_ratio"]
    return (spheres, f"{modulus * 1e-9:.5f}", f"{100 * (modulus / TRUE_MODULUS - 1):.2f}",
            f"{100 * (decay / TRUE_DECAY - 1):.2f}",
            f"{stem['parameters']['bond_damping']['value']:.2f}",
            f"{1e6 * stem['mode']['damping_time_s']:.2f}", f"{stem['fit']['rmse_mm']:.5f}")


def main(build: Path):
    print("| spheres | Y, GPa | error of Y, % | error of 2πζ, % | β | τ, µs | rms, mm |")
    print("|---|---|---|---|---|---|---|")
    for spheres in (28, 56, 112, 224):
        print("| " + " | ".join(map(str, row(build / "src" / "cli" / "culm", spheres))) + " |")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
