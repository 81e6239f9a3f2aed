#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The numbers with which jobs/local.sh ends: key_results.py DIR, or the effects that the diagnosis
found, joined by commas: key_results.py --effects DIR."""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "h5py")

import json
import math
import sys
from pathlib import Path

from report_page.markup import with_error
from study_laws import PUBLISHED_DAMPING, PUBLISHED_YOUNGS_MODULUS

# Of tests/data/demo-beam, and of tests/data/hidden-effect/T2-quadratic_drag.
TRUE_YOUNGS_MODULUS_GPA, TRUE_DAMPING_TIME_S, TRUE_DRAG = 1.9, 1e-4, 1.3


def document(folder: Path, name: str) -> dict:
    """Empty if the folder does not contain it."""
    file = folder / name
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}


def lines(folder: Path) -> list[str]:
    found = []
    for key, title, published in (
            ("sqrt_youngs_modulus", "slope of sqrt(Y) on b2", PUBLISHED_YOUNGS_MODULUS),
            ("bond_damping", "slope of beta on b1", PUBLISHED_DAMPING)):
        law = document(folder, "summary.json").get("regression", {}).get(key, {})
        if "slope" in law:
            found.append(f"{title:34}{law['slope']:.1f}  (published {published.slope})")
    for stem in document(folder / "calibration", "calibration.json").get("stems", [])[:1]:
        true_ratio = math.pi * stem["mode"]["b2_hz"]["value"] * TRUE_DAMPING_TIME_S
        modulus = with_error(stem["parameters"]["bond_youngs_modulus_pa"], 1e-9)
        found.append(f"{'Y of the filmed stem':34}{modulus} GPa  (true {TRUE_YOUNGS_MODULUS_GPA})")
        found.append(f"{'its damping ratio':34}{stem['mode']['damping_ratio']:.5f}  "
                     f"(true {true_ratio:.5f})")
    ladder = document(folder / "comparison", "comparison.json").get("ladder", [])
    if len(ladder) > 1:
        effects = " and ".join(ladder[-1]["model"][1:])
        drag = ladder[-1]["parameters"].get("quadratic_drag.drag_coefficient")
        size = f", C_d {with_error(drag)} (true {TRUE_DRAG})" if drag else ""
        found.append(f"{'residual / noise of the recording':34}{ladder[0]['rmse_over_noise']:.2f}, "
                     f"with {effects} {ladder[-1]['rmse_over_noise']:.2f}{size}")
    return found


def main() -> int:
    folder = Path(sys.argv[-1])
    if "--effects" in sys.argv:
        print(",".join(document(folder / "diagnosis", "diagnosis.json").get("effects", [])))
    else:
        print("\n".join(f"  {line}" for line in lines(folder)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
