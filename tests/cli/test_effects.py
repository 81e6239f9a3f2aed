# SPDX-License-Identifier: BSD-3-Clause
"""The library of effects and the formulas of users, as shown by culm effects."""

import json
import re
import sys
import unittest
from pathlib import Path

from culm_program import DONE, PROGRAM, CulmTest
from effects_reference import reference

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent
sys.path.insert(0, str(TESTS / "support"))
from json_schema import schema_faults, schema_of  # noqa: E402

SCHEMA = schema_of("effects")
DOCUMENT = (ROOT / "docs" / "effects.md").read_text("utf-8")
BEGIN, END = "<!-- tests/cli/effects_reference.py -->\n", "<!-- end -->\n"
EXAMPLES = sorted((ROOT / "config" / "effects").glob("*.toml"))

DRAG = """[effect]
name = "my_drag"
kind = "force_per_length"
expression = "-c*abs(v)*v"
[parameters.c]
default = 1e-3
lower = 0.0
upper = 1.0
"""


class Library(CulmTest):
    def test_is_listed_with_its_parameters(self):
        finished = self.culm("effects")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^quadratic_drag +air drag .* \[drag_coefficient\]$")

    def test_as_json_follows_its_schema_and_has_every_effect_of_the_list(self):
        cards = json.loads(self.culm("effects", "--json", "-").stdout)
        self.assertEqual(schema_faults(cards, SCHEMA), [])
        names = [line.split()[0] for line in self.culm("effects").stdout.splitlines() if "[" in line]
        self.assertEqual([card["name"] for card in cards["effects"]], names)

    def test_is_in_the_documents(self):
        documented = DOCUMENT.split(BEGIN)[1].split(END)[0]
        self.assertEqual(documented, reference(PROGRAM), "put what tests/cli/effects_reference.py "
                         "prints between the marks of docs/effects.md")

    def test_describes_the_signature_of_an_effect_and_what_to_do(self):
        finished = self.culm("effects", "clamp_friction")
        self.assert_exit(finished, DONE)
        for label in ("law", "source", "signature", "remedy", "energy", "contains"):
            self.assertRegex(finished.stdout, rf"(?m)^{label} +\w")
        self.assertIn("\nrate_rad_s = 0.05 rad/s (0.0001 to 10; known, not fitted)\n",
                      finished.stdout)

    def test_refuses_an_unknown_name_with_the_nearest(self):
        self.assert_refused(self.culm("effects", "tapper"),
                            'culm: there is no effect "tapper" (did you mean "taper"?); '
                            "`culm effects` lists those there are\n")


class UsersEffect(CulmTest):
    def test_examples_are_valid_and_documented(self):
        self.assertTrue(EXAMPLES)
        for example in EXAMPLES:
            self.assert_exit(self.culm("effects", str(example)), DONE)
            self.assertIn(f"config/effects/{example.name}", DOCUMENT)

    def test_is_valid_in_the_documents(self):
        blocks = re.findall(r"```toml\n(.*?)```", DOCUMENT, re.DOTALL)
        self.assertTrue(blocks)
        for block in blocks:
            self.assert_exit(self.culm("effects", "./" + self.write("block.toml", block)), DONE)

    def test_shows_its_formula(self):
        finished = self.culm("effects", self.write("mine.toml", DRAG))
        self.assert_exit(finished, DONE)
        self.assertIn("sideways force per length, N/m: -c*abs(v)*v\n", finished.stdout)

    def test_gets_a_caret_at_a_mistake_in_the_formula(self):
        name = self.write("mine.toml", DRAG.replace("abs(v)*v", "abs(v)*w"))
        finished = self.culm("effects", name)
        self.assertEqual(finished.returncode, 2)
        self.assertRegex(finished.stderr,
                         r'^culm: mine\.toml:4: effect\.expression: unknown name "w"; there are s, '
                         r"x, v, .*\n    -c\*abs\(v\)\*w\n              \^\n$")

    def test_is_refused_without_a_value_at_rest(self):
        name = self.write("mine.toml", DRAG.replace("abs(v)*v", "v/abs(v)"))
        self.assert_refused(
            self.culm("effects", name),
            "culm: mine.toml:4: effect.expression: effect my_drag: -c*v/abs(v) is not a number at "
            "s = 0, x = 0, v = 0, kappa = 0, kappa_rate = 0, t = 0, c = 0.001; a formula must have "
            "a value at rest and in every motion, for all that its parameters' bounds allow\n")

    def test_is_refused_if_it_has_a_name_of_the_library(self):
        name = self.write("mine.toml", DRAG.replace("my_drag", "taper"))
        self.assert_refused(self.culm("effects", name),
                            'culm: mine.toml:2: effect.name = "taper": is the name of an effect of '
                            "the library; choose another\n")

    def test_gets_all_of_its_errors_at_once(self):
        text = DRAG.replace("force_per_length", "force").replace("upper = 1.0", "upper = -1.0\n"
                                                                 "lowr = 2")
        finished = self.culm("effects", self.write("mine.toml", text))
        self.assertEqual(finished.returncode, 2)
        for line, fault in ((3, 'effect.kind = "force": must be "'),
                            (9, "parameters.c.lowr = 2: unknown key (did you mean lower?)")):
            self.assertIn(f"mine.toml:{line}: {fault}", finished.stderr)

    def test_is_refused_if_its_bounds_exclude_its_default(self):
        finished = self.culm("effects", self.write("mine.toml", DRAG.replace("1e-3", "2.0")))
        self.assert_refused(
            finished, "culm: mine.toml:6: parameters.c.default = 2: must lie from 0 to 1\n")

    def test_is_refused_without_a_file(self):
        self.assert_refused(self.culm("effects", "./none.toml"),
                            "culm: ./none.toml: cannot be read: No such file or directory\n")


if __name__ == "__main__":
    unittest.main()
