# SPDX-License-Identifier: BSD-3-Clause
"""The programs in postprocess/ on the command line."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

POSTPROCESS = Path(__file__).resolve().parents[2] / "postprocess"
PROGRAMS = [file for file in sorted(POSTPROCESS.glob("*.py"))
            if file.read_text("utf-8").startswith("#!")]


def without_other_python() -> dict:
    return {name: value for name, value in os.environ.items() if name != "CULM_PYTHON"}


# Programs that begin without a package.
NEED_NOTHING = ("reproduction_table.py", "setup.py")


class Programs(unittest.TestCase):
    def test_may_be_executed(self):
        self.assertGreaterEqual(len(PROGRAMS), 7)
        for program in PROGRAMS:
            self.assertTrue(os.access(program, os.X_OK), program.name)

    def test_say_in_a_sentence_which_packages_this_python_lacks(self):
        """Python finds only its standard library with -S."""
        for program in PROGRAMS:
            run = subprocess.run([sys.executable, "-B", "-S", program, "DIR"], text=True,
                                 capture_output=True, check=False, env=without_other_python())
            with self.subTest(program=program.name):
                self.assertNotIn("Traceback", run.stderr)
                if program.name not in NEED_NOTHING:
                    self.assertEqual(run.returncode, 2)
                    self.assertIn("jobs/install-packages.sh figures", run.stderr)


    def test_use_the_python_that_the_variable_names(self):
        with tempfile.TemporaryDirectory() as folder:
            other = Path(folder) / "python"
            other.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', "utf-8")
            other.chmod(0o755)
            run = subprocess.run([sys.executable, "-B", "-S", POSTPROCESS / "figures.py", "DIR"],
                                 text=True, capture_output=True, check=False,
                                 env={**os.environ, "CULM_PYTHON": str(other)})
        self.assertEqual(run.returncode, 2)
        self.assertNotIn("lacks", run.stderr)  # it ran, and found no folder DIR
        self.assertIn("DIR", run.stderr)


if __name__ == "__main__":
    unittest.main()
