# SPDX-License-Identifier: BSD-3-Clause
"""Runs the tests of postprocess/; exits with 77 if h5py, numpy or matplotlib is missing."""
import importlib.util
import sys
import unittest
from pathlib import Path

SKIPPED = 77
HERE = Path(__file__).resolve().parent


def main():
    missing = [m for m in ("h5py", "numpy", "matplotlib") if importlib.util.find_spec(m) is None]
    if missing:
        print(f"skipped: {', '.join(missing)} is not installed")
        return SKIPPED
    sys.path[:0] = [str(HERE), str(HERE.parent / "support"),
                    str(HERE.parents[1] / "postprocess")]
    tests = unittest.defaultTestLoader.discover(str(HERE), pattern="test_*.py")
    result = unittest.TextTestRunner(verbosity=2).run(tests)
    return 0 if result.wasSuccessful() and result.testsRun > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
