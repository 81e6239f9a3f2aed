# SPDX-License-Identifier: BSD-3-Clause
"""Output for people: progress on terminals, the cost before long work, the next command."""
import json
import os
import pty
import re
import subprocess
import unittest
import zlib
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PATIENCE, PROGRAM, QUICK, CulmTest

DATA = Path(__file__).resolve().parents[1] / "data"
NULL = str(DATA / "measurements" / "T1-null")
STEMS = str(DATA / "measurements")
DRAG = str(DATA / "hidden-effect" / "T2-quadratic_drag")
QUICKLY = ("--spheres", "20", "--window", "0.1")
SECONDS = r"[\d.e+]+ (s|min|h)"


class Terminal(CulmTest):
    def on_terminal(self, *arguments, code=DONE) -> str:
        """The output on a pseudo-terminal, which is both standard output and standard error."""
        environment = {**os.environ, "TERM": "xterm"}
        main, terminal = pty.openpty()
        with subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL,
                              stdout=terminal, stderr=terminal, env=environment) as process:
            os.close(terminal)
            printed = b""
            try:
                while block := os.read(main, 65536):
                    printed += block
            except OSError:
                pass  # Linux reports in this way that the other end is closed
            os.close(main)
            self.assertEqual(process.wait(timeout=PATIENCE), code, printed)
        return printed.decode()

    def test_shows_the_progress_of_a_study_as_a_bar(self):
        self.write("s.toml", QUICK)
        ran = self.on_terminal("run", "s.toml", "-o", "out")
        self.assertIn("9 of 9 points completed", ran)
        self.assertIn("[########################] 9/9 points", ran)

    def test_pipes_and_files_have_no_escape_sequences(self):
        for command in (("calibrate", NULL, *QUICKLY, "-o", "c"), ("compare", NULL, *QUICKLY),
                        ("fit", NULL), ("reduce", "nowhere"), ("runn",)):
            with self.subTest(command):
                finished = self.culm(*command, env={**os.environ, "TERM": "xterm"})
                self.assertNotIn("\x1b", finished.stdout + finished.stderr)
        self.assertNotIn("\x1b", (self.folder / "c" / "calibration.json").read_text("utf-8"))


class Cost(CulmTest):
    def test_is_stated_before_a_study_runs(self):
        self.write("s.toml", QUICK)
        told = self.culm("run", "s.toml", "-o", "out").stderr
        self.assertRegex(told, rf"^9 points to compute: about {SECONDS} of processor time on the "
                               r"reference machine; [\d.]+ kB on the disk before compression\n")
        again = self.culm("run", "s.toml", "-o", "out", "--resume").stderr
        self.assertNotIn("to compute", again)

    def test_is_not_printed_by_quiet_commands_nor_next_to_json(self):
        for command in (("calibrate", NULL, *QUICKLY), ("compare", NULL, *QUICKLY), ("fit", NULL)):
            with self.subTest(command):
                quiet = self.culm(*command, "-q")
                self.assertEqual(quiet.stderr, "")
                self.assertNotIn("next:", quiet.stdout)
                document = self.culm(*command, "--json", "-")
                self.assertEqual(document.stderr, "")
                json.loads(document.stdout)


class NextCommand(CulmTest):
    def next_of(self, *command) -> str:
        finished = self.culm(*command)
        self.assert_exit(finished, DONE)
        lines = finished.stdout.splitlines()
        self.assertEqual(lines[-2], "")
        self.assertTrue(lines[-1].startswith("next: culm "), lines[-1])
        return lines[-1].removeprefix("next: ")

    def test_leads_from_the_study_to_the_report(self):
        self.write("s.toml", QUICK)
        self.assertEqual(self.next_of("run", "s.toml", "-o", "my out", "-q"),
                         "culm report 'my out'")
        self.assertEqual(self.next_of("reduce", "my out"),
                         "culm calibrate MEASUREMENT --via 'my out'")

    def test_leads_from_the_measurement_to_the_diagnosis(self):
        self.assertEqual(self.next_of("fit", NULL), f"culm calibrate {NULL}")
        options = "--spheres 20 --window 0.1"
        self.assertEqual(self.next_of("calibrate", NULL, *QUICKLY), f"culm calibrate {NULL} {options} "
                         "--json calibration.json && culm export lammps calibration.json")
        self.assertEqual(self.next_of("calibrate", NULL, *QUICKLY, "-o", "c"),
                         "culm export lammps c/calibration.json")
        self.assertEqual(self.next_of("calibrate", DRAG, *QUICKLY), f"culm diagnose {DRAG} {options}")
        self.assertEqual(self.next_of("calibrate", STEMS, *QUICKLY), f"culm calibrate {STEMS} {options} "
                         "--json calibration.json && culm export lammps calibration.json")
        self.assertEqual(self.next_of("compare", NULL, *QUICKLY),
                         f"culm calibrate {NULL} {options}")
        self.assertEqual(self.next_of("compare", DRAG, *QUICKLY), f"culm diagnose {DRAG} {options}")


class Provenance(CulmTest):
    def test_states_the_command_the_cost_and_the_files(self):
        for command in (("fit", NULL), ("calibrate", NULL, *QUICKLY), ("compare", NULL, *QUICKLY),
                        ("diagnose", NULL, *QUICKLY, "--candidates", "taper")):
            with self.subTest(command[0]):
                document = json.loads(self.culm(*command, "--json", "-").stdout)
                facts = document["provenance"]
                self.assertEqual(facts["command"],
                                 " ".join(["culm", *command, "--json", "-"]))
                self.assertRegex(facts["version"], r"^culm \d+\.\d+\.\d+ \(.+\)$")
                self.assertRegex(facts["date"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
                self.assertEqual(facts["ranks"], 1)
                self.assertGreater(facts["processor_s"], 0.0)
                self.assertGreater(facts["wall_s"], 0.0)
                self.assertEqual([Path(entry["file"]).name for entry in facts["inputs"]],
                                 ["stem.toml", "deflection.csv"])
                for entry in facts["inputs"]:
                    content = Path(entry["file"]).read_bytes()
                    self.assertEqual(entry["bytes"], len(content))
                    self.assertEqual(entry["crc32"], f"{zlib.crc32(content):08x}")

    def test_names_files_of_effects_and_studies(self):
        effect = DATA.parents[1] / "config" / "effects" / "any_power_drag.toml"
        self.write("mine.toml", effect.read_text("utf-8"))
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "study", "-q"), DONE)
        found = json.loads(self.culm("calibrate", NULL, *QUICKLY, "--with", "./mine.toml", "--via",
                                     "study", "--json", "-").stdout)
        names = [re.sub(".*/", "", entry["file"]) for entry in found["provenance"]["inputs"]]
        self.assertEqual(names, ["stem.toml", "deflection.csv", "mine.toml", "study.h5"])


if __name__ == "__main__":
    unittest.main()
