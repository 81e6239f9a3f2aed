# SPDX-License-Identifier: BSD-3-Clause
"""Completion agrees with --help, and the shells accept its scripts."""

import shutil
import subprocess
import unittest

from culm_program import BAD_INPUT, PROGRAM, CulmTest

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


if __name__ == "__main__":
    assert PROGRAM
    unittest.main()
