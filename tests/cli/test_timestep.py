# SPDX-License-Identifier: BSD-3-Clause
"""A time-step study: its output and files, and the commands that do not apply to it."""

import json
import unittest

from culm_program import BAD_INPUT, DONE, CulmTest

STEPS = """
[study]
kind = "timestep"
[stem]
spheres = 8
[release]
tip_deflection_mm = 1
[factors]
bond_damping = [1, 2, 4]
bond_youngs_modulus_gpa = [1, 9]
[timestep]
fractions = [0.25, 0.5, 0.9]
"""


class Timestep(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", STEPS)

    def run_study(self):
        finished = self.culm("run", "s.toml", "-o", "out", "-q")
        self.assert_exit(finished, DONE)
        return finished

    def test_writes_limits_errors_and_summary_and_prints_the_laws(self):
        finished = self.run_study()
        self.assertEqual({path.name for path in (self.folder / "out").iterdir()},
                         {"study.h5", "summary.json"})
        summary = json.loads((self.folder / "out/summary.json").read_text(encoding="utf-8"))
        self.assertEqual((summary["kind"], summary["completed"]), ("timestep", 6))
        self.assertLess(summary["limits"]["bisected_over_linearised"]["largest"], 1.1)
        self.assertEqual([(row["fraction"], row["fitted"]) for row in summary["errors"]],
                         [(0.25, 6), (0.5, 6), (0.9, 6)])
        law = summary["regression"]["damped_oscillator"]["coefficients"]
        self.assertIn(f"A = {law[0]['coefficient']:.5g} (", finished.stdout)
        self.assertIn("6 of 6 points completed", finished.stdout)

    def test_is_reduced_again_from_its_archive(self):
        self.run_study()
        before = (self.folder / "out/summary.json").read_text(encoding="utf-8")
        (self.folder / "out/summary.json").unlink()
        self.assert_exit(self.culm("reduce", "out"), DONE)
        self.assertEqual((self.folder / "out/summary.json").read_text(encoding="utf-8"), before)

    def test_is_named_in_the_dry_run(self):
        finished = self.culm("run", "s.toml", "--dry-run")
        self.assert_exit(finished, DONE)
        self.assertIn("points         6 in 6 batches\n", finished.stdout)
        self.assertIn("explicit, the limit bisected to 0.01, b1 and b2 at 3 steps below it\n",
                      finished.stdout)

    def test_has_no_histories_to_fit_again(self):
        self.run_study()
        self.assert_refused(
            self.culm("reduce", "out", "--amplitude", "fixed"),
            "culm: out: a time-step study keeps no histories to fit again; --window, --amplitude "
            "and --significance are for vibrations\n")

    def test_calibrates_no_stem(self):
        self.run_study()
        finished = self.culm("simulate", "--via", "out", "--frequency-hz", "100",
                             "--decay-per-cycle", "-0.1")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("a time-step study holds no fits", finished.stderr)


if __name__ == "__main__":
    unittest.main()
