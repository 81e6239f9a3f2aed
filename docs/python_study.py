# SPDX-License-Identifier: BSD-3-Clause
"""The published design from Python, in cells (# %%) for a notebook or an editor.

    python3 python_study.py MEASUREMENT_FOLDER

Needs the package culm (docs/python.md), pandas and matplotlib.
"""
# %% Run the design of Schramm et al. (2019) with fewer levels
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import culm

design = {
    "study": {"name": "levels"},
    "stem": {"spheres": 56},
    "factors": {
        "bond_damping": [25, 75, 125],
        "bond_youngs_modulus_gpa": {"from": 1, "to": 9, "step": 2},
    },
}
study = culm.run(design, output="levels", ranks=2)
points = study.table()
print(len(points), "points,", (points.status == "completed").sum(), "completed")

# %% √Y over b2: the regression that calibrates Y
slope, intercept = np.polyfit(points.frequency, np.sqrt(points.bond_youngs_modulus_gpa), 1)
print(f"√Y = {slope:.5f} b2 + {intercept:.5f}, Y in GPa, b2 in Hz")
figure, axes = plt.subplots()
axes.plot(points.frequency, np.sqrt(points.bond_youngs_modulus_gpa), "k.")
axes.set(xlabel="frequency b2, Hz", ylabel="√Y, √GPa")
figure.savefig("levels.png")

# %% More levels later: only the new points are computed
design["factors"]["bond_youngs_modulus_gpa"] = {"from": 1, "to": 9, "step": 1}
larger = culm.run(design, output="levels", resume=True)
print(larger.points, "points now")

# %% Calibrate a measured stem
calibration = culm.calibrate(sys.argv[1], effects=["still_air"])
print(calibration[0].sentence)
print(calibration.table().T)
