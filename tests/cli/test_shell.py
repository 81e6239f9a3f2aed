# SPDX-License-Identifier: BSD-3-Clause
"""Completion and manual pages agree with --help, and the programs that read them accept them."""

import shutil
import subprocess
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PROGRAM, CulmTest

ASK = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
_culm
printf '%s\\n' "${COMPREPLY[@]}"
"""


class Completion(CulmTest):
    def offered(self, *words: str) -> set[str]:
        """The completions that bash offers for the last of these words."""
        script = self.folder / "culm.bash"
        script.write_text(self.culm("completion", "bash").stdout, encoding="utf-8")
        asked = subprocess.run(["bash", "-u", "-c", ASK, "bash", str(script), PROGRAM, *words],
                               cwd=self.folder, capture_output=True, text=True, check=True)
        self.assertEqual(asked.stderr, "")
        return set(asked.stdout.split())

    def test_offers_the_commands_for_the_first_word(self):
        self.assertLessEqual({"run", "archive", "diagnose", "report"}, self.offered(""))
        self.assertEqual(self.offered("arc"), {"archive"})

    def test_completes_commands_of_commands(self):
        self.assertEqual(self.offered("archive", "ver"), {"verify"})
        self.assertIn("--json", self.offered("archive", "verify", "--j"))

    def test_offers_the_choices_of_an_option_and_files_elsewhere(self):
        self.assertEqual(self.offered("calibrate", "--law", ""), {"schramm2019", "consistent"})
        self.assertIn("-o default", self.culm("completion", "bash").stdout)  # files, if nothing else
        self.assertEqual(self.offered("run", "stu"), set())
        self.assertEqual(self.offered("run", "x.toml", "-o", ""), set())

    def test_describes_each_word_for_fish(self):
        said = self.culm("complete", "archive", "ver").stdout
        self.assertEqual(said.split("\t")[0], "verify")
        self.assertIn("checksum", said)

    def test_does_not_offer_a_hidden_command(self):
        self.assertNotIn("complete", self.offered(""))

    def test_is_a_script_that_each_shell_accepts(self):
        for shell, check in (("bash", ["bash", "-n"]), ("zsh", ["zsh", "-n"]),
                             ("fish", ["fish", "--no-execute"])):
            script = self.folder / shell
            script.write_text(self.culm("completion", shell).stdout, encoding="utf-8")
            self.assertIn("culm", script.read_text(encoding="utf-8"))
            if shutil.which(shell):
                said = subprocess.run([*check, script], capture_output=True, text=True, check=False)
                self.assertEqual((said.returncode, said.stderr), (0, ""), shell)

    def test_is_refused_for_an_unknown_shell(self):
        finished = self.culm("completion", "tcsh")
        self.assertEqual(finished.returncode, BAD_INPUT)
        self.assertIn("tcsh", finished.stderr)


class Manual(CulmTest):
    def pages(self) -> dict[str, str]:
        self.assert_exit(self.culm("manual", "pages"), DONE)
        return {page.name: page.read_text(encoding="utf-8")
                for page in (self.folder / "pages").iterdir()}

    def test_has_a_page_for_every_command(self):
        listed = self.culm("--help").stdout.split("Subcommands:")[1].splitlines()
        commands = {line.split()[0] for line in listed if line.startswith("  ") and
                    not line.startswith("   ")}
        self.assertGreater(len(commands), 10)
        expected = {f"culm-{name}.1" for name in commands} | {"culm.1", "culm-archive-verify.1"}
        self.assertLessEqual(expected, set(self.pages()))

    def test_has_every_option_of_the_help(self):
        page = self.pages()["culm-diagnose.1"].replace("\\-", "-")
        for option in ("--known", "--candidates", "--spheres", "--json"):
            self.assertIn(option, page)

    @unittest.skipUnless(shutil.which("groff"), "there is no groff")
    def test_is_good_roff(self):
        self.pages()
        for page in sorted((self.folder / "pages").iterdir()):
            made = subprocess.run(["groff", "-man", "-Tutf8", "-Kutf8", "-ww", "-z", page],
                                  capture_output=True, text=True, check=True)
            self.assertEqual(made.stderr, "", page.name)

    def test_names_the_file_that_cannot_be_written(self):
        (self.folder / "pages").touch()
        finished = self.culm("manual", "pages")
        self.assertNotEqual(finished.returncode, DONE)
        self.assertIn("pages", finished.stderr)


if __name__ == "__main__":
    assert PROGRAM
    unittest.main()
