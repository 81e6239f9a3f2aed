# SPDX-License-Identifier: BSD-3-Clause
"""culm from Python (docs/python.md): starts the program, waits for it and reads its files.

    import culm

    study = culm.run({"factors": {"bond_damping": [25, 50], "bond_youngs_modulus_gpa": [1, 4]}},
                     output="results/small", ranks=2)
    study.table()                                   # a pandas DataFrame
    stem = culm.calibrate("measurements/stem-07", effects=["still_air"])[0]
    stem.parameters["bond_youngs_modulus_pa"].value
    culm.compare("measurements/stem-07", effects=["quadratic_drag"]).table()
    print(culm.diagnose("measurements/stem-07"))

Bad input raises InputError with culm's message, an early stop raises StoppedEarly, and points or
stems that failed are warned of (FailedPoints) and listed in the result.
"""
from culm.archive import Failure, Study, StudyError
from culm.commands import calibrate, compare, diagnose, run, simulate
from culm.program import CulmError, FailedPoints, InputError, StoppedEarly
from culm.results import Calibration, Comparison, Diagnosis, Estimate, Model, Simulation, Stem

__all__ = ["Calibration", "Comparison", "CulmError", "Diagnosis", "Estimate", "FailedPoints",
           "Failure", "InputError", "Model", "Simulation", "Stem", "StoppedEarly", "Study",
           "StudyError", "calibrate", "compare", "diagnose", "run", "simulate"]
