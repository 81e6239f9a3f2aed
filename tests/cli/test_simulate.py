# SPDX-License-Identifier: BSD-3-Clause
"""culm simulate: given parameters, and the closing test of the calibration."""

import csv
import json
import unittest

from culm_program import DONE, POINTS_FAILED, QUICK, CulmTest

# 56 spheres as in the paper, with a design around the requested stem.
CALIBRATION = """
[vibration]
duration_s = 0.05
[factors]
bond_damping = [80, 100, 120]
bond_youngs_modulus_gpa = [3, 4, 5]
"""


class ClosedLoop(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", CALIBRATION)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)

    def simulate(self, *options):
        return self.culm("simulate", "--via", "out", *options)

    def test_recovers_frequency_and_decay_of_stems_inside_the_design(self):
        for frequency, decay in ((111.0, -0.36), (102.0, -0.33), (118.0, -0.41)):
            finished = self.simulate("--frequency-hz", str(frequency), "--decay-per-cycle",
                                     str(decay), "--json", "-")
            self.assert_exit(finished, DONE)
            self.assertEqual(finished.stderr, "")
            by_law, by_terms = json.loads(finished.stdout)
            self.assertEqual(by_law["parameters_from"], "paper's laws")
            self.assertEqual(by_terms["parameters_from"], "F-test terms")
            # The curvature of the decay over this design causes an error of 0.2 % in a linear law;
            # the paper reports 1.8 % and 0.9 %, culm's aim is 0.3 %.
            self.assertAlmostEqual(by_terms["frequency_hz"] / frequency, 1, delta=0.003)
            self.assertAlmostEqual(by_terms["decay_per_cycle"] / decay, 1, delta=0.003)
            self.assertAlmostEqual(by_terms["frequency_error_percent"],
                                   100 * (by_terms["frequency_hz"] / frequency - 1), delta=1e-9)

    def test_prints_the_wanted_and_the_recovered_values(self):
        finished = self.simulate("--frequency-hz", "111", "--decay-per-cycle", "-0.36")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^F-test terms: Y = [34]\.\d+ GPa, beta = \d+\.\d+ "
                         r"\(law schramm2019\)$")
        self.assertRegex(finished.stdout,
                         r"b2 \(frequency\) +11\d\.\d+ Hz +wanted 111, error [+-]0\.\d+ %")
        self.assertRegex(finished.stdout,
                         r"b1 \(decay per cycle\) +-0\.3\d+ +wanted -0\.36, error [+-]0\.\d+ %")

    def test_warns_of_a_stem_outside_of_the_design(self):
        finished = self.simulate("--frequency-hz", "200", "--decay-per-cycle", "-0.36")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stderr, r"^culm: warning: the study covers decays per cycle of .* "
                                          r"this stem lies outside, the laws are extrapolated\n$")


class GivenParameters(CulmTest):
    def simulate(self, *options):
        self.write("s.toml", QUICK)
        return self.culm("simulate", "s.toml", *options)

    def test_give_the_fit_of_that_point_of_a_study(self):
        finished = self.simulate("--bond-youngs-modulus-gpa", "4", "--bond-damping", "10",
                                 "--json", "one.json")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"^given parameters: Y = 4\.0000 GPa, beta = 10\.000 "
                         r"\(law schramm2019\)\n")
        self.assertNotIn("wanted", finished.stdout)
        one, = json.loads((self.folder / "one.json").read_text(encoding="utf-8"))
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        with open(self.folder / "out/fits.csv", encoding="utf-8", newline="") as file:
            point = list(csv.DictReader(file))[4]
        # A study integrates in SIMD lanes, whose last digits round differently.
        for key in ("frequency_hz", "decay_per_cycle"):
            of_study = float(point[key])
            self.assertAlmostEqual(one[key] / of_study, 1.0, delta=1e-10)

    def test_stem_that_does_not_swing_has_no_fit(self):
        finished = self.simulate("--bond-youngs-modulus-gpa", "4", "--bond-damping", "30000")
        self.assert_exit(finished, POINTS_FAILED)
        self.assertEqual(finished.stdout, "")
        self.assertRegex(finished.stderr, r"^culm: the history does not vibrate: its best fit makes "
                                          r"0\.\d+ periods in 0\.05 s\n$")


if __name__ == "__main__":
    unittest.main()
