# SPDX-License-Identifier: BSD-3-Clause
"""`cmake --install` makes a tree that works after it is moved, and libraries to link."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

BUILD = os.environ["CULM_BUILD"]
CMAKE = os.environ["CULM_CMAKE"]
COMPILER = os.environ["CULM_CXX"]
GENERATOR = os.environ["CULM_GENERATOR"]  # a bare machine has Ninja and no make
CONSUMER = Path(__file__).resolve().parent / "consumer"


def output_of(*command, **options) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True,
                          check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        root = Path(cls.place.name)
        output_of(CMAKE, "--install", BUILD, "--prefix", root / "first place")
        (root / "first place").rename(root / "second place")
        cls.tree = root / "second place"
        cls.addClassCleanup(cls.place.cleanup)

    def test_program_runs_its_examples(self):
        example = self.tree / "share" / "culm" / "config" / "quick.toml"
        said = output_of(self.tree / "bin" / "culm", "run", example, "-o", self.tree / "quick")
        self.assertIn("9 points", said)
        self.assertTrue((self.tree / "quick" / "study.h5").exists())

    def test_figures_lie_where_they_are_looked_for(self):
        for place in ("share/culm/postprocess/figures.py", "share/culm/postprocess/report.py",
                      "lib/python3/dist-packages/culm/__init__.py",
                      "share/doc/culm/copyright", "bin/culm-track"):
            self.assertTrue((self.tree / place).exists(), place)

    def test_nothing_names_the_machine_that_built_it(self):
        for file in (self.tree / "lib").rglob("*.cmake"):
            for place in (BUILD, str(CONSUMER.parents[2])):
                self.assertNotIn(place, file.read_text(encoding="utf-8"), file.name)

    def test_libraries_serve_a_program_of_somebody_else(self):
        build = self.tree / "consumer"
        output_of(CMAKE, "-G", GENERATOR, "-S", CONSUMER, "-B", build, f"-DCMAKE_PREFIX_PATH={self.tree}",
                  f"-DCMAKE_CXX_COMPILER={COMPILER}", "-DCMAKE_BUILD_TYPE=Debug")
        output_of(CMAKE, "--build", build)
        tip_mm, crossings = output_of(build / "consumer").split()
        self.assertAlmostEqual(float(tip_mm), 10.0, places=2)
        self.assertGreater(int(crossings), 4)


if __name__ == "__main__":
    unittest.main()
