# SPDX-License-Identifier: BSD-3-Clause
"""culm compare: where a model fails, and what an effect makes of it."""

import json
import shutil
import sys
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, CulmTest

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent
sys.path.insert(0, str(TESTS / "support"))
from json_schema import schema_faults  # noqa: E402

SCHEMA = json.loads((ROOT / "docs" / "schemas" / "comparison.schema.json").read_text("utf-8"))
TABLE_SCHEMA = json.loads(
    (ROOT / "docs" / "schemas" / "effect-table.schema.json").read_text("utf-8"))
RECORDS = TESTS / "data"
NULL, DRAG = RECORDS / "measurements" / "T1-null", RECORDS / "hidden-effect" / "T2-quadratic_drag"
# Enough spheres for an error below the noise, few enough to be quick.
QUICK = ("--spheres", "30")


class Compare(CulmTest):
    def test_shows_that_the_published_chain_lacks_something_and_where(self):
        finished = self.culm("compare", DRAG, *QUICK, "--json", "found.json")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^baseline .* something is missing$")
        self.assertIn("the measured decay per cycle goes from", finished.stdout)
        found = json.loads((self.folder / "found.json").read_text("utf-8"))
        self.assertEqual(schema_faults(found, SCHEMA), [])
        rung, = found["ladder"]
        self.assertEqual(rung["verdict"]["finding"], "inadequate")
        residuals = rung["where"]["residual_map"]["residual_mm"]
        self.assertEqual([len(residuals), len(residuals[0])], [found["frames"], found["heights"]])
        heights = rung["where"]["by_height"]
        self.assertEqual(max(heights, key=lambda group: group["rms_over_noise"]), heights[-1])

    def test_watches_the_error_fall_to_the_noise_with_the_missing_effect(self):
        finished = self.culm("compare", DRAG, *QUICK, "--with", "quadratic_drag", "-o", "out")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^baseline \+ quadratic_drag .* fits$")
        self.assertIn("quadratic_drag is a gain: BIC falls by", finished.stdout)
        found = json.loads((self.folder / "out" / "comparison.json").read_text("utf-8"))
        self.assertEqual(schema_faults(found, SCHEMA), [])
        before, after = found["ladder"]
        self.assertGreater(before["rmse_over_noise"], 3.0)
        self.assertLess(after["rmse_over_noise"], 1.10)
        drag = after["parameters"]["quadratic_drag.drag_coefficient"]
        self.assertAlmostEqual(drag["value"], 1.3, delta=0.15 * 1.3)  # the truth of the record
        header = (self.folder / "out" / "deflections.csv").read_text("utf-8").splitlines()[0]
        self.assertEqual(header.split(",")[:4],
                         ["time_s", "measured h=14mm", "model 1 h=14mm", "model 2 h=14mm"])

    def test_says_that_the_record_without_a_hidden_effect_is_explained(self):
        finished = self.culm("compare", NULL, *QUICK)
        self.assert_exit(finished, DONE)
        self.assertIn("The model fits:", finished.stdout)

    def test_does_not_depend_on_the_order_in_which_effects_are_named(self):
        texts = [self.culm("compare", DRAG, "--spheres", "12", "--with", names, "--json", "-").stdout
                 for names in ("taper,quadratic_drag", "quadratic_drag,taper")]
        one, other = (json.loads(text)["ladder"][1] for text in texts)
        self.assertEqual(one, other)

    def test_says_that_a_record_is_too_short_to_tell(self):
        finished = self.culm("compare", NULL, *QUICK, "--window", "0.01")
        self.assert_exit(finished, DONE)
        self.assertIn("This record cannot tell: 10 frames", finished.stdout)

    def test_says_that_nothing_moves_a_stem_that_is_held_straight(self):
        shutil.copytree(NULL, self.folder / "held")
        stem = self.folder / "held" / "stem.toml"
        stem.write_text(stem.read_text("utf-8") + '[release]\nkind = "held_straight"\n', "utf-8")
        finished = self.culm("compare", "held", *QUICK)
        self.assert_exit(finished, DONE)
        self.assertIn("Nothing in this model moves a stem", finished.stdout)


class Table(CulmTest):
    def test_has_every_effect_alone_and_what_is_named(self):
        finished = self.culm("compare", "--table", DRAG, "--spheres", "8", "--window", "0.06",
                             "--with", "quadratic_drag,taper", "--json", "table.json")
        self.assert_exit(finished, DONE)
        table = json.loads((self.folder / "table.json").read_text("utf-8"))
        self.assertEqual(schema_faults(table, TABLE_SCHEMA), [])
        listed = self.culm("effects").stdout.splitlines()
        names = [line.split()[0] for line in listed if "[" in line]
        self.assertEqual([row["name"] for row in table["models"]],
                         ["baseline", *names, "taper,quadratic_drag"])
        ratios = {row["name"]: row["cells"][0].get("rmse_over_noise", float("inf"))
                  for row in table["models"]}
        single = {name: ratios[name] for name in names}
        self.assertEqual(min(single, key=single.get), "quadratic_drag")
        self.assertLessEqual(ratios["taper,quadratic_drag"], 1.001 * ratios["quadratic_drag"])


class BadInput(CulmTest):
    def test_is_refused_in_words(self):
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

    def test_shows_the_place_of_a_mistake_in_a_formula(self):
        self.write("drag.toml", '[effect]\nname = "my_drag"\nkind = "force_per_length"\n'
                                'expression = "-c*abs(v*v"\n[parameters.c]\ndefault = 1e-3\n'
                                "lower = 0.0\nupper = 1.0\n")
        finished = self.culm("compare", NULL, "--with", "./drag.toml")
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"(?m)^ *\^$")

    def test_of_several_measurements_points_to_the_table(self):
        self.assert_refused(self.culm("compare", NULL, DRAG),
                            "culm: 2 measurements; compare takes one, --table takes many\n")


if __name__ == "__main__":
    unittest.main()
