# SPDX-License-Identifier: BSD-3-Clause
"""Tests a page of documentation: every command must run, every output must be as printed.

A fenced block marked sh contains commands. A block marked text directly after it contains their
standard output, or their error output if there is no other. The blocks run one after the other in
one folder, with `~/culm` replaced by the repository, its build folder by that of the program under
test, and `mpirun -n N` by a launcher of two processes. A tutorial begins in an empty folder, and
every block of it is a command or an output. A page of reference may begin with files (`given`) and
contain other blocks. Outputs are compared by these rules:
 * a line `…` matches any lines, `…` inside a line matches any text (or the character itself,
   which culm prints between the ends of an interval);
 * numbers may differ by 2 %, those with a decimal point or an exponent also by one unit of the
   last printed digit: fits end within a small part of their standard error, and processors round
   differently;
 * everything else is literal, except for the width of the gaps between words.
"""

import os
import re
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from culm_program import PROGRAM, SLOWNESS, launcher

ROOT = Path(__file__).resolve().parents[2]
NEEDED_FOR_FIGURES = ("matplotlib", "numpy")
# Seconds after which a block is taken to hang; the slowest takes half a minute on an idle core.
PATIENCE = 300 * SLOWNESS

FENCE = re.compile(r"^```(.*)\n((?:(?!```).*\n)*)^```$", re.MULTILINE)
# Excludes digits that are part of a name (T2, chi2) and the punctuation of intervals and lists.
NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w])")
ANYTHING = "…"
TOLERANCE = 0.02


class Step:
    """Commands, and their output (None if the tutorial does not show it)."""

    def __init__(self, commands: str, line: int):
        self.commands, self.line = commands, line
        self.output: str | None = None

    @property
    def draws(self) -> bool:
        return "_figures.py" in self.commands


def steps_of(text: str, only_commands: bool = True) -> list[Step]:
    """The steps of a page. Raises ValueError for a block that is neither commands nor their output,
    unless the page may contain other blocks."""
    steps, end_of_commands = [], -1
    for block in FENCE.finditer(text):
        language, content = block.groups()
        line = text.count("\n", 0, block.start()) + 1
        if language == "sh":
            steps.append(Step(content, line))
            end_of_commands = block.end()
        elif language == "text" and text[end_of_commands:block.start()] == "\n":
            steps[-1].output = content
        elif only_commands:
            raise ValueError(f"line {line}: a block without a command: ```{language}")
    return steps


def words(line: str) -> str:
    return " ".join(line.split())


def last_digit(number: str) -> float:
    """One unit of the last written digit: 0.01 for 1.25, 1e5 for 2e+05, 0 for a count."""
    if number.lstrip("+-").isdigit():
        return 0.0
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def agree(expected: str, found: str, uncertainty: float = 0.0) -> bool:
    wanted, value = float(expected), float(found)
    # The factor 1.01 allows for a difference of one unit, which is not exact in binary. A number
    # that is consistent with 0 may differ between processors by more than 2 % of its value.
    return abs(value - wanted) <= max(TOLERANCE * abs(wanted), 1.01 * last_digit(expected),
                                      TOLERANCE * uncertainty)


def line_agrees(expected: str, found: str) -> bool:
    """Whether a line matches the line of the tutorial, with numbers within the tolerance."""
    expected, found = words(expected), words(found)
    pattern, end = "", 0
    numbers: list[str] = []
    uncertainties: list[float] = []
    for match in re.finditer(f"{NUMBER.pattern}|{ANYTHING}", expected):
        pattern += re.escape(expected[end:match.start()])
        if match[0] == ANYTHING:
            pattern += ".*"
        else:
            pattern += f"({NUMBER.pattern})"
            if numbers and expected[end:match.start()] == " ± ":
                uncertainties[-1] = float(match[0])
            numbers.append(match[0])
            uncertainties.append(0.0)
        end = match.end()
    matched = re.fullmatch(pattern + re.escape(expected[end:]), found)
    return bool(matched) and all(map(agree, numbers, matched.groups(), uncertainties))


def difference(expected: str, found: str) -> str | None:
    """The first line that differs between the tutorial and the output; None if there is none."""
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


class ExecutedPage:
    """Tests of a page, for a unittest.TestCase that defines `page`."""

    page: Path
    is_tutorial = True
    # First line of a block that is not run -> why not.
    left_out: dict[str, str] = {}
    # Beginning of a command of culm -> options that shorten it; only where no output is shown.
    small: dict[str, str] = {}

    @classmethod
    def setUpClass(cls):
        cls.text = cls.page.read_text("utf-8")
        cls.steps = steps_of(cls.text, cls.is_tutorial)

    def given(self, folder: Path):
        """Puts the files into the folder that the page needs."""

    def test_does_what_it_says(self):
        can_draw = all(map(find_spec, NEEDED_FOR_FIGURES))
        with tempfile.TemporaryDirectory() as scratch:
            folder, variables = Path(scratch) / "empty", Path(scratch) / "variables"
            folder.mkdir()
            self.given(folder)
            programs = self.programs(Path(scratch) / "bin")
            # The figures need the Python interpreter of this test.
            variables.write_text(f"export PATH='{programs}:{ROOT / 'postprocess'}:"
                                 f"{Path(sys.executable).parent}':$PATH\n", "utf-8")
            for step in self.steps:
                if step.commands.splitlines()[0] in self.left_out:
                    continue
                if step.draws and not can_draw:
                    print(f"line {step.line}: needs {' and '.join(NEEDED_FOR_FIGURES)}, left out")
                    continue
                with self.subTest(line=step.line):
                    self.run_step(step, folder, variables)

    def programs(self, folder: Path) -> Path:
        """A folder with a `culm` that adds the options of `small`."""
        folder.mkdir()
        cases = "".join(f"\"{command} \"*) set -- \"$@\" {options} ;;\n"
                        for command, options in self.small.items())
        program = folder / "culm"
        program.write_text(f'#!/bin/sh\ncase "$*" in\n{cases}esac\nexec "{PROGRAM}" "$@"\n',
                           "utf-8")
        program.chmod(0o755)
        return folder

    def run_step(self, step: Step, folder: Path, variables: Path) -> str:
        """`variables` passes the exports of a block to the next one, as in one terminal."""
        commands = step.commands.replace("~/culm/build/release/src/cli", str(Path(PROGRAM).parent))
        commands = commands.replace("~/culm", str(ROOT))
        commands = re.sub(r"\bmpirun -n \d+", " ".join(launcher(2)), commands)
        finished = subprocess.run(
            ["bash", "-e", "-o", "pipefail", "-c",
             f'. "{variables}"\n{commands}\nexport -p > "{variables}"'],
            cwd=folder, text=True, capture_output=True, timeout=PATIENCE, check=False,
            env={**os.environ, "LC_ALL": "C.UTF-8", "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertEqual(finished.returncode, 0, step.commands + finished.stderr)
        if step.output is not None:
            printed = finished.stdout or finished.stderr
            fault = difference(step.output, printed)
            self.assertIsNone(fault, f"{fault}\n--- all that was printed:\n{printed}")
        return finished.stdout

    def test_shows_what_every_culm_command_prints(self):
        if self.is_tutorial:
            for step in self.steps:
                self.assertIsNotNone(step.output, f"line {step.line}: {step.commands}")

    def test_shows_no_output_of_commands_that_were_made_small(self):
        for step in self.steps:
            if re.search("|".join(rf"culm {command}\b" for command in self.small) or "$^",
                         step.commands):
                self.assertIsNone(step.output, f"line {step.line}")
