# SPDX-License-Identifier: BSD-3-Clause
"""The Python package culm: docs/python.md, the script beside it, errors, and the model server."""

import json
import os
import shutil
import subprocess
import sys
import unittest
import unittest.mock
import urllib.error
import urllib.request
import warnings
from importlib.util import find_spec
from pathlib import Path

from culm_program import OVERDAMPED, PROGRAM, QUICK, CulmTest
from executed_page import ROOT, ExecutedPage

sys.path.insert(0, str(ROOT / "postprocess"))
import culm  # noqa: E402

RECORDING = ROOT / "tests" / "data" / "lab-rig" / "R02"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "postprocess"), "PYTHONDONTWRITEBYTECODE": "1"}


class Page(ExecutedPage, unittest.TestCase):
    page = ROOT / "docs" / "python.md"
    is_tutorial = False

    def given(self, folder: Path):
        shutil.copytree(RECORDING, folder / "stem")


class Script(CulmTest):
    @unittest.skipUnless(find_spec("matplotlib"), "matplotlib is missing")
    def test_runs_all_its_cells(self):
        finished = subprocess.run([sys.executable, ROOT / "docs" / "python_study.py", RECORDING],
                                  cwd=self.folder, env=ENVIRONMENT, text=True, capture_output=True,
                                  check=False)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        self.assertIn("15 points, 15 completed\n", finished.stdout)
        self.assertIn("27 points now\n", finished.stdout)
        self.assertIn("R02: Y = ", finished.stdout)
        self.assertIn("15 of 27 points are there", finished.stderr)  # progress and notes
        self.assertTrue((self.folder / "levels.png").stat().st_size > 1000)


class Package(CulmTest):
    def setUp(self):
        super().setUp()
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)

    def test_writes_every_kind_of_value_of_a_study(self):
        import numpy
        study = {"study": {"name": 'of "x"', "heights_mm": [], "effects": ["gravity"]},
                 "stem": {"spheres": numpy.int64(12), "length_mm": numpy.float64(155.65)},
                 "factors": {"bond_damping": numpy.array([5, 10]), "bond_youngs_modulus_gpa": {
                     "distribution": "normal", "mean": 4.0, "sd": 0.5, "min": 1}},
                 "replicates": {"stems": 3}}
        import tomllib
        from culm.study_text import study_text
        read = tomllib.loads(study_text(study))
        self.assertEqual(read["study"], study["study"])
        self.assertEqual(read["stem"], {"spheres": 12, "length_mm": 155.65})
        self.assertEqual(read["factors"]["bond_youngs_modulus_gpa"]["sd"], 0.5)
        with self.assertRaisesRegex(culm.InputError, "stem.spheres = nan"):
            study_text({"stem": {"spheres": float("nan")}})

    def test_names_the_folder_as_the_program_does(self):
        self.write("named.toml", '[study]\nname = "mine"\n' + QUICK)
        self.assertEqual(culm.run("named.toml", ranks=1, progress=False).path,
                         Path("results/mine/study.h5"))
        with self.assertRaisesRegex(culm.InputError, "needs a name"):
            culm.run({"stem": {"spheres": 12}})

    def test_raises_the_messages_of_the_program(self):
        self.write("s.toml", QUICK)
        culm.run("s.toml", "out", ranks=1, progress=False)
        with self.assertRaisesRegex(culm.InputError, "^out already holds this study"):
            culm.run("s.toml", "out", ranks=1, progress=False)
        self.assertEqual(culm.run("s.toml", "out", ranks=1, resume=True, progress=False).points, 9)
        with self.assertRaisesRegex(culm.StoppedEarly, "--resume"):
            limited = subprocess.run(["bash", "-c", "ulimit -f 8; exec \"$@\"", "bash",
                                      sys.executable, "-c",
                                      "import culm\ntry:\n    culm.run('s.toml', 'full', ranks=1)\n"
                                      "except culm.StoppedEarly as error:\n    print(error)"],
                                     env=ENVIRONMENT, text=True, capture_output=True, check=False)
            raise culm.StoppedEarly(limited.stdout)
        with self.assertRaisesRegex(culm.InputError, "there is no such folder"):
            culm.calibrate("nowhere", progress=False)
        with self.assertRaisesRegex(culm.InputError, "quadratic_drag"):
            culm.calibrate(RECORDING, effects=["quadratic_darg"], progress=False)

    def test_warns_of_failed_points_and_lists_them(self):
        self.write("s.toml", '[study]\nstore = "fit"\n' + OVERDAMPED)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            study = culm.run("s.toml", "out", ranks=1, progress=False)
        self.assertEqual([warning.category for warning in caught], [culm.FailedPoints])
        self.assertEqual({failure.point for failure in study.failures}, {6, 7, 8})

    def test_finds_the_program_by_variable_or_says_what_is_missing(self):
        from culm import program
        for path, found in ((PROGRAM, PROGRAM), ("/nowhere/culm", None)):
            with unittest.mock.patch.dict(os.environ, {"CULM_PROGRAM": path, "PATH": ""}):
                if found:
                    self.assertEqual(program.program_path(), found)
                else:
                    with self.assertRaisesRegex(culm.CulmError, "CULM_PROGRAM names it"):
                        program.program_path()


class Server(CulmTest):
    """A plain HTTP client speaks the protocol."""

    def setUp(self):
        super().setUp()
        self.write("model.toml", "[stem]\nspheres = 12\n[factors]\nbond_damping = [1, 2]\n")
        server = subprocess.Popen(
            [sys.executable, "-m", "culm.model_server", "model.toml", "--port", "0", "--effect",
             "quadratic_drag.drag_coefficient"], cwd=self.folder, env=ENVIRONMENT, text=True,
            stdout=subprocess.PIPE)
        self.addCleanup(self.end, server)
        self.address = server.stdout.readline().strip()

    def ask(self, path: str, question=None):
        """Status and answer."""
        data = None if question is None else json.dumps(question).encode()
        try:
            with urllib.request.urlopen(self.address + path, data, timeout=60) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as error:
            with error:
                return error.code, json.load(error)

    def test_describes_itself(self):
        self.assertEqual(self.ask("/Info"), (200, {"protocolVersion": 1.0, "models": ["culm"]}))
        about = {"name": "culm", "config": {}}
        self.assertEqual(self.ask("/InputSizes", about), (200, {"inputSizes": [3]}))
        self.assertEqual(self.ask("/OutputSizes", about), (200, {"outputSizes": [2]}))
        support = self.ask("/ModelInfo", {"name": "culm"})[1]["support"]
        self.assertEqual({key for key, value in support.items() if value}, {"Evaluate"})

    def evaluate(self, *values: float):
        return self.ask("/Evaluate", {"name": "culm", "input": [list(values)], "config": {}})

    def test_evaluates_as_the_program_does(self):
        status, answer = self.evaluate(4.0, 10.0, 0.0)
        self.assertEqual(status, 200, answer)
        self.culm("simulate", "model.toml", "--bond-youngs-modulus-gpa", "4", "--bond-damping",
                  "10", "--json", "plain.json")
        plain = json.loads((self.folder / "plain.json").read_text())[0]
        decay, frequency = answer["output"][0]
        self.assertAlmostEqual(decay, plain["decay_per_cycle"], places=5)
        self.assertAlmostEqual(frequency, plain["frequency_hz"], places=3)
        with_drag = self.evaluate(4.0, 10.0, 2.0)[1]["output"][0]
        self.assertLess(with_drag[0], decay)

    def test_refuses_what_is_wrong(self):
        for question, kind in (({"name": "other", "input": [[1, 2, 3]]}, "ModelNotFound"),
                               ({"name": "culm", "input": [[1, 2]]}, "InvalidInput"),
                               ({"name": "culm", "input": [["x", 2, 3]]}, "InvalidInput"),
                               ({"name": "culm", "input": [[-1.0, 2, 3]]}, "InvalidInput"),
                               ({"name": "culm"}, "InvalidInput")):
            status, answer = self.ask("/Evaluate", question)
            self.assertEqual((status, answer["error"]["type"]), (400, kind), question)
        self.assertEqual(self.ask("/Gradient", {"name": "culm"})[1]["error"]["type"],
                         "UnsupportedFeature")
        self.assertEqual(self.ask("/nothing")[0], 404)


if __name__ == "__main__":
    unittest.main()
