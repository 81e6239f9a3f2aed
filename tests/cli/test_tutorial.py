# SPDX-License-Identifier: BSD-3-Clause
"""docs/tutorial-hidden-effect.md is correct, and its sentences quote the printed numbers."""

import re
import unittest

from executed_page import FENCE, NUMBER, ROOT, ExecutedPage, difference, line_agrees, steps_of

README = ROOT / "README.md"
HIDDEN = ROOT / "tests" / "data" / "hidden-effect" / "README.md"


def significant_digits(number: str) -> str:
    return re.sub(r"e.*|[+.-]", "", number).lstrip("0")


class Tutorial(ExecutedPage, unittest.TestCase):
    page = ROOT / "docs" / "tutorial-hidden-effect.md"

    def run_step(self, step, folder, variables):
        """Runs the diagnosis, which takes half a minute, once for this page and for README.md."""
        printed = super().run_step(step, folder, variables)
        if step.commands == "culm diagnose first -o diagnosis\n":
            shown = next(other for other in steps_of(README.read_text("utf-8"), False)
                         if other.commands.startswith("culm diagnose "))
            printed = printed.replace("first --", f"{shown.commands.split()[2]} --")
            self.assertIsNone(difference(shown.output, printed), "README.md")

    def test_numbers_in_its_sentences_are_those_of_its_outputs(self):
        """Numbers may also be those of the recordings' truth, rounded and with any unit prefix."""
        shown = "\n".join(step.commands + (step.output or "") for step in self.steps)
        known = {significant_digits(number) for number in
                 NUMBER.findall(shown + HIDDEN.read_text("utf-8"))}
        prose = FENCE.sub("", self.text).replace("−", "-")
        for number in NUMBER.findall(prose):
            if "." not in number:
                continue
            digits = significant_digits(number)
            with self.subTest(number=number):
                self.assertTrue(any(abs(float(f"0.{digits}") - float(f"0.{other}"))
                                    <= 0.51 * 10.0 ** -len(digits) for other in known if other))


class Comparison(unittest.TestCase):
    def test_allows_two_percent_or_the_last_digit_of_numbers(self):
        self.assertTrue(line_agrees("rms 1.000 mm", "rms   1.019 mm"))
        self.assertFalse(line_agrees("rms 1.000 mm", "rms 1.021 mm"))
        self.assertTrue(line_agrees("7.0e-07 ± 3.2e-06 N m", "7.3e-07 ± 3.2e-06 N m"))
        self.assertFalse(line_agrees("7.00e-07 ± 3.2e-06 N m", "8.00e-07 ± 3.2e-06 N m"))
        self.assertTrue(line_agrees("p = 0.01", "p = 0.02"))
        self.assertFalse(line_agrees("mode 1 of 3", "mode 2 of 3"))
        self.assertFalse(line_agrees("beta -42.6 %", "beta +42.6 %"))
        self.assertTrue(line_agrees("p <1e-12, Y 2e+05", "p <1e-12, Y 3e+05"))

    def test_is_literal_for_words(self):
        self.assertFalse(line_agrees("T2: fits", "T7: fits"))
        self.assertFalse(line_agrees("(fits)", "(misses)"))
        self.assertTrue(line_agrees("next: … --with x", "next: culm compare d --with x"))

    def test_skips_lines_only_where_the_tutorial_says_so(self):
        self.assertIsNone(difference("a\n…\nc\n", "a\nb\nb\nc\n"))
        self.assertIsNone(difference("a\n…\n", "a\nb\n"))
        self.assertIn("printed:  b", difference("a\nc\n", "a\nb\nc\n"))
        self.assertIn("not printed: x", difference("a\n…\nx\n", "a\nb\nc\n"))
        self.assertIn("not in the tutorial: b", difference("a\n", "a\nb\n"))

    def test_refuses_a_block_that_no_command_prints(self):
        with self.assertRaises(ValueError):
            steps_of("```text\n4.85\n```\n")
        with self.assertRaises(ValueError):
            steps_of("```sh\nls\n```\nprints\n```text\n4.85\n```\n")


if __name__ == "__main__":
    unittest.main()
