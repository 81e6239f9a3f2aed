# SPDX-License-Identifier: BSD-3-Clause
"""culm report: calls its Python program and returns its exit code."""

import os
import subprocess
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PATIENCE, PROGRAM, QUICK, CulmTest

PYTHON = "/usr/bin/python3"
ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
LIBRARY = '!function(){var d3={version:"3.5.17"};this.d3=d3}();'


def lacks_modules() -> bool:
    finished = subprocess.run([PYTHON, "-c", "import h5py, numpy"], capture_output=True,
                              check=False)
    return finished.returncode != 0


class Report(CulmTest):
    def report(self, *arguments, python=PYTHON):
        return self.culm("report", *arguments, env={**os.environ, "CULM_PYTHON": python})

    def setUp(self):
        super().setUp()
        self.write("d3.min.js", LIBRARY)

    @unittest.skipIf(lacks_modules(), "h5py or numpy is not installed")
    def test_is_one_page_with_the_results_of_all_commands(self):
        self.write("quick.toml", QUICK)
        recording = str(DATA / "hidden-effect" / "T2-quadratic_drag")
        stem = str(DATA / "measurements" / "T1-null")
        for arguments in (("run", "quick.toml", "-o", "all", "-q"),
                          ("fit", stem, "-o", "all/fit"),
                          ("calibrate", stem, "-o", "all/calibration"),
                          ("compare", recording, "--with", "quadratic_drag", "-o", "all/comparison"),
                          ("diagnose", recording, "--candidates", "quadratic_drag,taper", "-q",
                           "-o", "all/diagnosis")):
            self.assert_exit(self.culm(*arguments), DONE)
        finished = self.report("all", "-o", "page.html", "--d3-js", "d3.min.js")
        self.assert_exit(finished, DONE)
        self.assertEqual((finished.stdout, finished.stderr), ("page.html\n", ""))
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        for words in ("All 9 points were computed.", "EFFECT: air (most like quadratic_drag) is missing",
                      "The published chain is inadequate for T2; with quadratic_drag it is adequate."):
            self.assertIn(words, page)
        self.assertNotIn("Not on this page", page)
        for key in ("study", "fit", "calibration", "comparison", "diagnosis"):
            self.assertIn(f'<section id="{key}"', page)

    @unittest.skipIf(lacks_modules(), "h5py or numpy is not installed")
    def test_is_written_to_the_folder_of_results_whatever_its_name(self):
        self.write("quick.toml", QUICK)
        self.assert_exit(self.culm("run", "quick.toml", "-o", "-a folder; $(touch x)", "-q"), DONE)
        finished = self.report("--d3-js", "d3.min.js", "--", "-a folder; $(touch x)")
        self.assert_exit(finished, DONE)
        self.assertTrue((self.folder / "-a folder; $(touch x)" / "report.html").is_file())
        self.assertFalse((self.folder / "x").exists())

    @unittest.skipIf(lacks_modules(), "h5py or numpy is not installed")
    def test_refuses_a_folder_without_results(self):
        finished = self.report(".", "--d3-js", "d3.min.js")
        self.assertEqual(finished.returncode, BAD_INPUT)
        self.assertRegex(finished.stderr, r"^culm report: \. holds no results: .*\n$")

    def test_says_what_is_missing(self):
        finished = self.report(".", python="/nowhere/python3")
        self.assert_refused(finished, "culm: /nowhere/python3: cannot be run: No such file or "
                            "directory; a report needs Python 3 with h5py and numpy "
                            "(jobs/install-packages.sh figures report) (the variable CULM_PYTHON "
                            "names another Python)\n")

    def test_finds_its_program_through_a_link(self):
        link = self.folder / "linked"
        link.symlink_to(PROGRAM)
        finished = subprocess.run([link, "report", "."], cwd=self.folder, text=True,
                                  capture_output=True, timeout=PATIENCE, check=False,
                                  env={**os.environ, "CULM_PYTHON": "/bin/echo"})
        self.assertEqual(finished.returncode, DONE)
        program = finished.stdout.split()[1]
        self.assertTrue(program.endswith("share/culm/postprocess/report.py"))
        self.assertTrue(Path(program).is_file())


if __name__ == "__main__":
    unittest.main()
