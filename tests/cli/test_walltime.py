# SPDX-License-Identifier: BSD-3-Clause
"""--walltime: a run ends in time, keeps its points and can be resumed; useless runs are refused."""

import json
import os
import re
import unittest

from culm_program import (BAD_INPUT, DONE, PATIENCE, PROGRAM, QUICK, STOPPED_EARLY, CulmTest,
                          launcher)

LAUNCH = launcher(2)

# 4000 points of some milliseconds each: more than a run of a few seconds computes.
ENDLESS = """
[stem]
spheres = 56
[vibration]
duration_s = 0.4
[factors]
bond_damping = { from = 5, to = 90, count = 50 }
bond_youngs_modulus_gpa = { from = 1, to = 9, count = 80 }
"""


class Walltime(CulmTest):
    def kept_points(self, finished) -> int:
        said = re.search(r"culm: stopped early before the walltime ends; (\d+) of 4000 points are "
                         r"computed and kept in out\. Continue with --resume\.\n", finished.stderr)
        self.assertIsNotNone(said, finished.stderr)
        return int(said[1])

    def test_ends_the_run_with_exit_code_75_and_each_run_adds_points(self):
        self.write("s.toml", ENDLESS)
        before = 0
        for resume in ([], ["--resume"]):
            finished = self.culm("run", "s.toml", "-o", "out", "--walltime", "4s", *resume)
            self.assert_exit(finished, STOPPED_EARLY)
            self.assertIn("culm: this run ends within 00:00:04 (--walltime); 00:00:03 of that may "
                          "be computed\n", finished.stderr)
            kept = self.kept_points(finished)
            self.assertGreater(kept, before)
            before = kept
            # The next run knows the computing time of the points.
            pace = json.loads((self.folder / "out/journal/pace.json").read_text(encoding="utf-8"))
            self.assertGreater(pace["seconds"], 0)
        status = self.culm("archive", "status", "out", "--json", "-")
        self.assertEqual(json.loads(status.stdout)["points"]["completed"], before)

    def test_ends_both_ranks(self):
        self.write("s.toml", ENDLESS)
        process = self.start(*LAUNCH, PROGRAM, "run", "s.toml", "-o", "out", "-q", "--walltime",
                             "5s")
        _, errors = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, STOPPED_EARLY, errors)
        self.assertEqual(errors.count("stopped early before the walltime ends"), 1, errors)

    def test_changes_nothing_if_it_suffices(self):
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "--walltime", "2h"), DONE)
        self.assertEqual(self.fits("out"), self.fits_of_undisturbed_run("s.toml"))
        self.assertFalse((self.folder / "out/journal").exists())

    def test_is_refused_without_a_retry_if_no_point_fits(self):
        # A run reserves one second for an orderly end.
        self.write("s.toml", QUICK)
        finished = self.culm("run", "s.toml", "-o", "out", "--walltime", "1s", "-q")
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr,
                         r"^culm: none of the 9 missing points can be computed in the walltime of "
                         r"this run; the shortest takes about 00:00:01 on the reference machine; "
                         r"give it a longer --walltime \(job limit\)\n$")

    def test_is_refused_without_a_unit(self):
        self.write("s.toml", QUICK)
        self.assert_refused(
            self.culm("run", "s.toml", "-o", "out", "--walltime", "90"),
            'culm: --walltime: "90" is not a duration above zero and of at most a year; allowed '
            "are HH:MM:SS, MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a number with its unit: 90s, "
            "45min, 12h, 2d\n")

    def test_counts_from_the_start_of_the_shell_of_a_pbs_job(self):
        self.write("s.toml", QUICK)
        environment = os.environ | {"PBS_JOBID": "1.server", "PBS_WALLTIME": "1000000"}
        environment.pop("SLURM_JOB_ID", None)
        finished = self.culm("run", "s.toml", "-o", "out", env=environment,
                             start_new_session=True)
        self.assert_exit(finished, DONE)
        # The new session is a few seconds old at most; 1e6 s are 11 days, 13:46:40.
        self.assertRegex(finished.stderr,
                         r"culm: this run ends within 11-13:4[56]:\d\d \(PBS_WALLTIME\)")

    def test_does_not_depend_on_a_damaged_note_of_the_pace(self):
        self.write("s.toml", ENDLESS)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q", "--walltime", "3s"),
                         STOPPED_EARLY)
        for text in ("", "{", '{"format": "culm-pace"}',
                     '{"format": "culm-pace", "estimated_seconds": -1, "seconds": 1, '
                     '"seconds_squared_per_estimated_second": 1}'):
            (self.folder / "out/journal/pace.json").write_text(text, encoding="utf-8")
            finished = self.culm("run", "s.toml", "-o", "out", "-q", "--resume", "--walltime",
                                 "3s")
            self.assert_exit(finished, STOPPED_EARLY)


if __name__ == "__main__":
    unittest.main()
