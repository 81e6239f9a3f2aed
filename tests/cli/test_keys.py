# SPDX-License-Identifier: BSD-3-Clause
"""The keys of study files in culm keys and in docs/config.md."""

import re
import unittest
from pathlib import Path

from culm_program import DONE, CulmTest

DOCUMENT = (Path(__file__).resolve().parents[2] / "docs" / "config.md").read_text("utf-8")
BEGIN, END = "<!-- culm keys --markdown -->\n", "<!-- end -->\n"


class Keys(CulmTest):
    def printed(self, *arguments: str) -> str:
        finished = self.culm("keys", *arguments)
        self.assert_exit(finished, DONE)
        return finished.stdout

    def test_are_in_the_documents(self):
        documented = DOCUMENT.split(BEGIN)[1].split(END)[0]
        self.assertEqual(documented, self.printed("--markdown"),
                         "put what `culm keys --markdown` prints between the marks of "
                         "docs/config.md")

    def test_are_listed_table_by_table_as_in_the_reference(self):
        names = re.sub(r"(?m)^\[.*\]$", "", self.printed().split("\n`")[0])
        self.assertEqual(set(re.findall(r"[a-z]\w*", names)),
                         set(re.findall(r"(?m)^\| `(\w+)` ", self.printed("--markdown"))))

    def test_have_range_unit_and_default(self):
        text = self.printed("stem")
        self.assertTrue(text.startswith("[stem]\nspheres\n"
                                        "    a whole number in [2, 10000]; default 56\n"))
        self.assertIn("bond_youngs_modulus_gpa\n    a number in (0, 10000] GPa; default 1\n", text)
        self.assertNotIn("tip_deflection_mm", text)

    def test_are_listed_for_every_table_that_has_the_name(self):
        text = self.printed("name")
        self.assertIn("[study]\nname\n", text)
        self.assertIn("\n[law]\nname\n", text)
        self.assertEqual(self.printed("law.name").count("\nname\n"), 1)
        self.assertIn("[factors.<parameter>]\nwithin_sd\n", self.printed("factors.within_sd"))

    def test_are_refused_with_the_nearest_if_they_do_not_exist(self):
        self.assert_refused(self.culm("keys", "bond_dampin"),
                            'culm: there is no table or key "bond_dampin" in a study file (did you '
                            'mean "bond_damping"?); `culm keys` lists those there are\n')


if __name__ == "__main__":
    unittest.main()
