# SPDX-License-Identifier: BSD-3-Clause
"""docs/cli.md contains --help of every command, and mistyped commands get a helpful answer."""

import re
import unittest
from pathlib import Path

from command_reference import reference
from culm_program import BAD_INPUT, DONE, PROGRAM, CulmTest

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "cli.md"
BEGIN, END = "<!-- tests/cli/command_reference.py -->\n", "<!-- end -->\n"
COMMANDS = ("run", "reduce", "simulate", "import", "effects", "keys", "fit", "setup", "track",
            "calibrate", "compare", "diagnose", "report", "export", "schema")
NESTED = tuple(f"archive {name}" for name in ("info", "status", "verify", "merge"))


def reference_section(command: str) -> str:
    """The rows of a command in docs/cli.md."""
    return DOCUMENT.read_text("utf-8").split(f"### `culm {command}`\n")[1].split("\n### ")[0]


def options_in(help_text: str) -> dict[tuple[str, ...], str]:
    """The names of each option, and its description."""
    options = {}
    for names, text in re.findall(r"^  (-[\w,-]+)(.*(?:\n {10,}.*)*)", help_text, re.MULTILINE):
        options[tuple(names.split(","))] = text
    return options


class Help(CulmTest):
    def test_is_a_command_too(self):
        for command in ((), ("fit",), ("archive", "verify")):
            self.assertEqual(self.culm("help", *command).stdout,
                             self.culm(*command, "--help").stdout)

    def test_lists_the_commands_and_the_exit_codes(self):
        finished = self.culm("--help")
        self.assert_exit(finished, DONE)
        for command in COMMANDS:
            self.assertRegex(finished.stdout, rf"(?m)^  {command} +\w")
        for code in ("0 done", "2 bad input", "3 some points failed", "75 stopped early"):
            self.assertIn(code, finished.stdout)

    def test_is_the_reference_in_the_documents(self):
        documented = DOCUMENT.read_text("utf-8").split(BEGIN)[1].split(END)[0]
        self.assertEqual(documented, reference(PROGRAM),
                         "put what tests/cli/command_reference.py prints between the marks of "
                         "docs/cli.md")

    def test_describes_each_option_of_every_command(self):
        for command in COMMANDS + NESTED:
            help_text = self.culm(*command.split(), "--help").stdout
            described = options_in(help_text)
            self.assertIn(("-h", "--help"), described, command)
            section = reference_section(command)
            for names, text in described.items():
                self.assertRegex(text, r"[A-Za-z]\w+ \w+", f"{command} {names}")
                if "--help" not in names:
                    self.assertIn(f"`{', '.join(names)}", section, command)

    def test_version_names_program_and_number(self):
        finished = self.culm("--version")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"^culm \d+\.\d+\.\d+ \(.+\)\n$")


class MistypedCommand(CulmTest):
    def test_gets_the_nearest_command(self):
        self.assert_refused(
            self.culm("simulat", "x.toml"),
            'culm: there is no command "simulat" (did you mean `culm simulate`?)\n'
            "Try `culm --help`.\n")

    def test_gets_no_command_if_it_is_far_from_all(self):
        self.assert_refused(self.culm("xyzzy"),
                            'culm: there is no command "xyzzy"\nTry `culm --help`.\n')

    def test_is_reported_if_it_is_missing(self):
        self.assert_refused(self.culm(), "culm: A subcommand is required\nTry `culm --help`.\n")

    def test_is_named_with_its_help_for_a_wrong_option(self):
        self.assert_refused(
            self.culm("run", "x.toml", "--dryrun"),
            "culm run: The following argument was not expected: --dryrun\n"
            "Try `culm run --help`.\n")

    def test_missing_study_is_bad_input(self):
        finished = self.culm("reduce")
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"^culm reduce: \w+ is required\n")


if __name__ == "__main__":
    unittest.main()
