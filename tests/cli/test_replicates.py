# SPDX-License-Identifier: BSD-3-Clause
"""A population of stems: its summary, on any number of ranks and without its table."""

import json
import unittest

from culm_program import BAD_INPUT, DONE, PATIENCE, PROGRAM, CulmTest, journal_bytes, launcher

LAUNCH = launcher(3)

POPULATION = """
[study]
name = "population"
store = "fit"
[stem]
spheres = 8
[vibration]
duration_s = 5e-3
sample_interval_s = 2e-5
[factors]
bond_youngs_modulus_gpa = { distribution = "empirical", file = "stems.csv", column = "modulus", unit = "GPa", rows = "together" }
bond_damping = { distribution = "normal", mean = 8, sd = 2, min = 2, max = 14, within_sd = 0.5 }
density_kg_m3 = { distribution = "empirical", file = "stems.csv", column = "density_kg_m3", rows = "together" }
tip_deflection_mm = { distribution = "uniform", min = 0.5, max = 1.5, level = "test" }
[design]
type = "latin_hypercube"
points = 24
[replicates]
within = 3
"""

STEMS = "id,modulus,density_kg_m3\na,1.0,120\nb,1.4,131\nc,2.2,118\nd,3.1,129\n"


class Replicates(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("stems.csv", STEMS)
        self.study = self.write("s.toml", POPULATION)

    def summary(self, folder: str) -> dict:
        return json.loads((self.folder / folder / "summary.json").read_text(encoding="utf-8"))

    def fits(self, folder: str) -> bytes:
        return (self.folder / folder / "fits.csv").read_bytes()

    def test_print_and_write_the_spread(self):
        finished = self.culm("run", self.study, "-o", "out")
        self.assert_exit(finished, DONE)
        for text in ("Spread of 72 points", "sd between stems", "Where the spread comes from",
                     "bond_youngs_modulus_gpa, density_kg_m3 depend on each other"):
            self.assertIn(text, finished.stdout)
        summary = self.summary("out")
        self.assertEqual(summary["population"]["frequency"]["count"], 72)
        components = summary["variance_components"]["decay_per_cycle"]
        self.assertEqual((components["stems"], components["tests"]), (24, 72))
        self.assertGreater(components["intraclass_correlation"]["value"], 0.5)
        stem = "bond_youngs_modulus_gpa, density_kg_m3"
        found = summary["variance_shares"]["frequency"]
        shares = {entry["group"]: entry["share"] for entry in found["shares"]}
        self.assertEqual(set(shares), {stem, "bond_damping", "tip_deflection_mm"})
        # The frequency is proportional to the root of the modulus, which varies threefold.
        self.assertGreater(shares[stem], 0.8)
        self.assertLess(found["rest"]["value"], 0.05)

    def test_show_stems_and_tests_in_the_plan(self):
        finished = self.culm("run", self.study, "--dry-run")
        self.assert_exit(finished, DONE)
        self.assertIn("stems          24, 3 tests of each\n", finished.stdout)

    def test_are_the_same_stems_after_an_interruption(self):
        self.write("long.toml", POPULATION.replace("points = 24", "points = 800"))
        self.assert_exit(self.culm("run", "long.toml", "-o", "whole", "-q"), DONE)
        process = self.start(PROGRAM, "run", "long.toml", "-o", "parts", "-q")
        while process.poll() is None and journal_bytes(self.folder / "parts") <= 20000:
            pass
        process.kill()
        process.wait()
        self.assert_exit(self.culm("run", "long.toml", "-o", "parts", "--resume", "-q"), DONE)
        self.assertEqual(self.fits("whole"), self.fits("parts"))

    def test_give_the_same_tables_on_any_number_of_ranks(self):
        self.assert_exit(self.culm("run", self.study, "-o", "alone", "-q"), DONE)
        process = self.start(*LAUNCH, PROGRAM, "run", self.study, "-o", "ranks", "-q")
        _, errors = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, DONE, errors)
        self.assertEqual(self.fits("alone"), self.fits("ranks"))
        one, other = self.summary("alone"), self.summary("ranks")
        for key in ("population", "variance_components", "variance_shares"):
            self.assertEqual(one[key], other[key])

    def test_are_reduced_from_the_archive_without_the_table(self):
        self.assert_exit(self.culm("run", self.study, "-o", "out", "-q"), DONE)
        before = self.summary("out")
        (self.folder / "stems.csv").unlink()
        self.assert_exit(self.culm("reduce", "out"), DONE)
        self.assertEqual(self.summary("out"), before)

    def test_are_another_study_with_another_table(self):
        self.assert_exit(self.culm("run", self.study, "-o", "out", "-q"), DONE)
        self.write("stems.csv", STEMS.replace("3.1", "3.2"))
        refused = self.culm("run", self.study, "-o", "out", "--resume")
        self.assert_exit(refused, BAD_INPUT)
        self.assertIn("factors.bond_youngs_modulus_gpa", refused.stderr)


if __name__ == "__main__":
    unittest.main()
