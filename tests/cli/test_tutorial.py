# SPDX-License-Identifier: BSD-3-Clause
"""docs/tutorial-hidden-effect.md does what it says: every command runs, every output is as printed.

A fenced block marked sh holds commands; a block marked text right behind it holds what they print
on the standard output. The blocks run one after the other in one empty folder, with `~/culm`
replaced by the repository and its build folder by that of the program under test. Of the output
 * a line of nothing but `…` stands for any lines, `…` inside a line for any text (or the
   character itself, which culm prints between the ends of an interval);
 * numbers may differ by 2 %, those with a decimal point or an exponent by one unit of the last
   digit that is printed if that is more: fits end within a small part of their standard error,
   and processors round differently;
 * everything else is literal, but for the width of the gaps between words.
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from importlib.util import find_spec
from pathlib import Path

from culm_program import PROGRAM

ROOT = Path(__file__).resolve().parents[2]
TUTORIAL = ROOT / "docs" / "tutorial-hidden-effect.md"
HIDDEN = ROOT / "tests" / "data" / "hidden-effect" / "README.md"
NEEDED_FOR_FIGURES = ("matplotlib", "numpy")
# Seconds after which a block hangs; the slowest takes half a minute of an idle core.
PATIENCE = 300

FENCE = re.compile(r"^```(.*)\n((?:(?!```).*\n)*)^```$", re.MULTILINE)
# Neither part of a word (T2, chi2) nor an interval's or a list's punctuation.
NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w])")
ANYTHING = "…"
TOLERANCE = 0.02


class Step:
    """Commands, and what they print (None where the tutorial does not show it)."""

    def __init__(self, commands: str, line: int):
        self.commands, self.line = commands, line
        self.output: str | None = None

    @property
    def draws(self) -> bool:
        return "_figures.py" in self.commands


def steps_of(text: str) -> list[Step]:
    """Raises ValueError where a block is neither commands nor the output of commands."""
    steps, end_of_commands = [], -1
    for block in FENCE.finditer(text):
        language, content = block.groups()
        line = text.count("\n", 0, block.start()) + 1
        if language == "sh":
            steps.append(Step(content, line))
            end_of_commands = block.end()
        elif language == "text" and text[end_of_commands:block.start()] == "\n":
            steps[-1].output = content
        else:
            raise ValueError(f"line {line}: a block that no command stands for: ```{language}")
    return steps


def words(line: str) -> str:
    return " ".join(line.split())


def last_digit(number: str) -> float:
    """One unit of the last digit that is written: 0.01 of 1.25, 1e5 of 2e+05, 0 of a count."""
    if number.lstrip("+-").isdigit():
        return 0.0
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def agree(expected: str, found: str) -> bool:
    wanted, value = float(expected), float(found)
    # A hundredth more, for a difference of one unit is not exact in binary.
    return abs(value - wanted) <= max(TOLERANCE * abs(wanted), 1.01 * last_digit(expected))


def line_agrees(expected: str, found: str) -> bool:
    """Whether a line is as the tutorial has it, numbers within the tolerance."""
    expected, found = words(expected), words(found)
    pattern, end = "", 0
    numbers = []
    for match in re.finditer(f"{NUMBER.pattern}|{ANYTHING}", expected):
        pattern += re.escape(expected[end:match.start()])
        if match[0] == ANYTHING:
            pattern += ".*"
        else:
            pattern += f"({NUMBER.pattern})"
            numbers.append(match[0])
        end = match.end()
    matched = re.fullmatch(pattern + re.escape(expected[end:]), found)
    return bool(matched) and all(map(agree, numbers, matched.groups()))


def difference(expected: str, found: str) -> str | None:
    """The first line of the tutorial that was not printed where it should be; None if all were."""
    printed = found.splitlines()
    place, skipping = 0, False
    for line in expected.splitlines():
        if line.strip() == ANYTHING:
            skipping = True
            continue
        while skipping and place < len(printed) and not line_agrees(line, printed[place]):
            place += 1
        if place == len(printed):
            return f"not printed: {line}"
        if not line_agrees(line, printed[place]):
            return f"tutorial: {line}\nprinted:  {printed[place]}"
        place, skipping = place + 1, False
    if place < len(printed) and not skipping:
        return f"not in the tutorial: {printed[place]}"
    return None


def significant_digits(number: str) -> str:
    return re.sub(r"e.*|[+.-]", "", number).lstrip("0")


class Tutorial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.text = TUTORIAL.read_text("utf-8")
        cls.steps = steps_of(cls.text)

    def test_does_what_it_says(self):
        can_draw = all(map(find_spec, NEEDED_FOR_FIGURES))
        with tempfile.TemporaryDirectory() as scratch:
            folder, variables = Path(scratch) / "empty", Path(scratch) / "variables"
            folder.mkdir()
            variables.touch()
            for step in self.steps:
                if step.draws and not can_draw:
                    print(f"line {step.line}: needs {' and '.join(NEEDED_FOR_FIGURES)}, left out")
                    continue
                with self.subTest(line=step.line):
                    self.run_step(step, folder, variables)

    def run_step(self, step: Step, folder: Path, variables: Path):
        """`variables` carries what a block exports to the next, as in one terminal."""
        commands = step.commands.replace("~/culm/build/release/src/cli", str(Path(PROGRAM).parent))
        commands = commands.replace("~/culm", str(ROOT))
        finished = subprocess.run(
            ["bash", "-e", "-o", "pipefail", "-c",
             f'. "{variables}"\n{commands}\nexport -p > "{variables}"'],
            cwd=folder, text=True, capture_output=True, timeout=PATIENCE, check=False,
            # The figures need the Python that runs this test.
            env={**os.environ, "LC_ALL": "C.UTF-8", "PYTHONDONTWRITEBYTECODE": "1",
                 "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"})
        self.assertEqual(finished.returncode, 0, step.commands + finished.stderr)
        if step.output is not None:
            fault = difference(step.output, finished.stdout)
            self.assertIsNone(fault, f"{fault}\n--- all that was printed:\n{finished.stdout}")

    def test_shows_what_every_culm_command_prints(self):
        for step in self.steps:
            self.assertIsNotNone(step.output, f"line {step.line}: {step.commands}")

    def test_numbers_in_its_sentences_are_those_of_its_outputs(self):
        """Or those that are hidden in the recordings; rounded, and whatever the unit's prefix."""
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

    def test_links_lead_somewhere(self):
        for target in re.findall(r"\]\(([^)#]+)", self.text):
            self.assertTrue((TUTORIAL.parent / target).exists(), target)


class Comparison(unittest.TestCase):
    def test_of_numbers_allows_two_percent_or_the_last_digit(self):
        self.assertTrue(line_agrees("rms 1.000 mm", "rms   1.019 mm"))
        self.assertFalse(line_agrees("rms 1.000 mm", "rms 1.021 mm"))
        self.assertTrue(line_agrees("p = 0.01", "p = 0.02"))
        self.assertFalse(line_agrees("mode 1 of 3", "mode 2 of 3"))
        self.assertFalse(line_agrees("beta -42.6 %", "beta +42.6 %"))
        self.assertTrue(line_agrees("p <1e-12, Y 2e+05", "p <1e-12, Y 3e+05"))

    def test_of_words_is_literal(self):
        self.assertFalse(line_agrees("T2: fits", "T7: fits"))
        self.assertFalse(line_agrees("(fits)", "(misses)"))
        self.assertTrue(line_agrees("next: … --with x", "next: culm compare d --with x"))

    def test_of_lines_skips_only_where_the_tutorial_says_so(self):
        self.assertIsNone(difference("a\n…\nc\n", "a\nb\nb\nc\n"))
        self.assertIsNone(difference("a\n…\n", "a\nb\n"))
        self.assertIn("printed:  b", difference("a\nc\n", "a\nb\nc\n"))
        self.assertIn("not printed: x", difference("a\n…\nx\n", "a\nb\nc\n"))
        self.assertIn("not in the tutorial: b", difference("a\n", "a\nb\n"))

    def test_of_blocks_refuses_one_that_nothing_makes(self):
        with self.assertRaises(ValueError):
            steps_of("```text\n4.85\n```\n")
        with self.assertRaises(ValueError):
            steps_of("```sh\nls\n```\nprints\n```text\n4.85\n```\n")


if __name__ == "__main__":
    unittest.main()
