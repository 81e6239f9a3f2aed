# SPDX-License-Identifier: BSD-3-Clause
"""culm compare: where a model fails, and how an effect changes that."""

import json
import re
import shutil
import sys
import unittest
from pathlib import Path
from random import Random

from culm_program import BAD_INPUT, DONE, POINTS_FAILED, CulmTest

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent
sys.path.insert(0, str(TESTS / "support"))
from json_schema import schema_faults, schema_of  # noqa: E402

SCHEMA = schema_of("comparison")
RECORDS = TESTS / "data"
NULL, DRAG = RECORDS / "measurements" / "T1-null", RECORDS / "hidden-effect" / "T2-quadratic_drag"
# Enough spheres for an error below the noise, few enough to be quick.
QUICK = ("--spheres", "30")


class Compare(CulmTest):
    def test_shows_that_the_published_chain_lacks_something_and_where(self):
        finished = self.culm("compare", DRAG, *QUICK, "--json", "found.json")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^baseline .* inadequate$")
        self.assertIn("of amplitude the measured frequency goes from", " ".join(finished.stdout.split()))
        lines = finished.stdout.splitlines()
        self.assertLessEqual(len(lines), 25)
        self.assertLessEqual(max(map(len, lines)), 100)
        found = json.loads((self.folder / "found.json").read_text("utf-8"))
        self.assertEqual(schema_faults(found, SCHEMA), [])
        rung, = found["ladder"]
        self.assertEqual(rung["verdict"]["finding"], "inadequate")
        residuals = rung["where"]["residual_map"]["residual_mm"]
        self.assertEqual([len(residuals), len(residuals[0])], [found["frames"], found["heights"]])
        heights = rung["where"]["by_height"]
        self.assertEqual(max(heights, key=lambda group: group["rms_over_noise"]), heights[-1])

    def test_reaches_the_noise_with_the_missing_effect(self):
        finished = self.culm("compare", DRAG, *QUICK, "--with", "quadratic_drag", "-o", "out")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^\+ quadratic_drag .* adequate$")
        self.assertIn("quadratic_drag improves on the baseline: the log evidence rises by", finished.stdout)
        found = json.loads((self.folder / "out" / "comparison.json").read_text("utf-8"))
        self.assertEqual(schema_faults(found, SCHEMA), [])
        before, after = found["ladder"]
        self.assertEqual(found["best"], 1)
        self.assertTrue(found["headline"].endswith("; with quadratic_drag it is adequate."))
        self.assertIn(after["step"].split(". Y changes")[0], finished.stdout)
        self.assertEqual(after["verdict"]["finding"], "adequate")
        self.assertGreater(before["rmse_over_noise"], 3.0)
        self.assertLess(after["rmse_over_noise"], 1.10)
        drag = after["parameters"]["quadratic_drag.drag_coefficient"]
        self.assertAlmostEqual(drag["value"], 1.3, delta=0.15 * 1.3)  # the truth of the record
        header = (self.folder / "out" / "deflections.csv").read_text("utf-8").splitlines()[0]
        self.assertEqual(header.split(",")[:4],
                         ["time_s", "measured h=14mm", "baseline h=14mm",
                          "baseline + quadratic_drag h=14mm"])

    def test_says_that_the_record_without_a_hidden_effect_is_explained(self):
        finished = self.culm("compare", NULL, *QUICK)
        self.assert_exit(finished, DONE)
        self.assertIn("The model is adequate:", finished.stdout)

    def test_does_not_depend_on_the_order_in_which_effects_are_named(self):
        texts = [self.culm("compare", DRAG, "--spheres", "12", "--with", names, "--json", "-").stdout
                 for names in ("taper,quadratic_drag", "quadratic_drag,taper")]
        one, other = (json.loads(text)["ladder"][1] for text in texts)
        self.assertEqual(one, other)

    def test_says_that_a_record_is_too_short(self):
        finished = self.culm("compare", NULL, *QUICK, "--window", "0.01")
        self.assert_exit(finished, DONE)
        self.assertIn("Undecided: 10 frames", finished.stdout)

    def test_says_that_nothing_moves_a_stem_that_is_held_straight(self):
        shutil.copytree(NULL, self.folder / "held")
        stem = self.folder / "held" / "stem.toml"
        stem.write_text(stem.read_text("utf-8") + '[release]\nkind = "held_straight"\n', "utf-8")
        finished = self.culm("compare", "held", *QUICK)
        self.assert_exit(finished, DONE)
        self.assertIn("Nothing in this model moves a stem", finished.stdout)


class BadInput(CulmTest):
    def test_is_refused_with_a_message(self):
        refusals = {
            "quadratic_dreg": 'culm: there is no effect "quadratic_dreg" (did you mean '
                              '"quadratic_drag"?); `culm effects` lists those there are\n',
            "taper(relative_change=7)": "culm: taper.relative_change = 7: must be a number from -1 "
                                        "to 1\n",
            "clamp_friction,clamp_compliance":
                "culm: effects clamp_friction and clamp_compliance cannot be combined: "
                "clamp_friction contains clamp_compliance; leave clamp_compliance out\n",
        }
        for option in ("--with", "--ladder"):
            for effects, message in refusals.items():
                with self.subTest(option=option, effects=effects):
                    self.assert_refused(self.culm("compare", NULL, option, effects), message)

    def formula(self, expression):
        return "./" + self.write(
            "drag.toml", '[effect]\nname = "my_drag"\nkind = "force_per_length"\n'
            f'expression = "{expression}"\n[parameters.c]\ndefault = 1e-3\nlower = 0.0\n'
            "upper = 1.0\n")

    def test_names_where_a_formula_has_no_value(self):
        finished = self.culm("compare", NULL, "--with", self.formula("-c*v/abs(v)"))
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("effect my_drag: -c*v/abs(v) is not a number at s = 0, x = 0, v = 0",
                      finished.stderr)

    def test_lists_a_model_whose_formula_loses_its_value_later_as_failed(self):
        # The tip swings by 19 mm, but only by 10 mm in the motions with which formulas are tested.
        finished = self.culm("compare", NULL, *QUICK, "--with",
                             self.formula("-c*v*sqrt(0.015 - x)"))
        self.assert_exit(finished, POINTS_FAILED)
        self.assertRegex(finished.stdout, r"(?m)^\+ my_drag +failed: effect my_drag: "
                                          r"-c\*v\*sqrt\(0.015 - x\) is not a number at s = ")
        self.assertIn("\nmy_drag could not be fitted.\n", finished.stdout)

    def test_is_refused_if_it_is_only_noise(self):
        shutil.copytree(NULL, self.folder / "noisy")
        stem = self.folder / "noisy" / "stem.toml"
        stem.write_text(re.sub("noise_mm = .*", "noise_mm = 30.0", stem.read_text("utf-8")), "utf-8")
        table = self.folder / "noisy" / "deflection.csv"
        head, *lines = table.read_text("utf-8").splitlines()
        random = Random(1)
        noisy = [",".join([time, *(f"{float(cell) + random.gauss(0, 30):.3f}" for cell in cells)])
                 for time, *cells in (line.split(",") for line in lines)]
        table.write_text("\n".join([head, *noisy]) + "\n", "utf-8")
        finished = self.culm("compare", "noisy", *QUICK)
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"(?m)^culm: T1: the readings after the release \(rms .* mm\) "
                                          r"cannot be distinguished from noise \(30 mm\)")

    def test_shows_the_position_of_a_mistake_in_a_formula(self):
        finished = self.culm("compare", NULL, "--with", self.formula("-c*abs(v*v"))
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"(?m)^ *\^$")

    def test_takes_one_measurement_and_one_list_of_effects(self):
        self.assert_refused(self.culm("compare", NULL, DRAG),
                            "culm: 2 measurements; compare takes one\n")
        self.assert_refused(self.culm("compare", NULL, "--with", "taper", "--with", "gravity"),
                            "culm: --with may be given only once; separate the effects by commas, "
                            "--with A,B\n")


if __name__ == "__main__":
    unittest.main()
