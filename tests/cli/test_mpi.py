# SPDX-License-Identifier: BSD-3-Clause
"""culm under mpirun: output from one rank only, and the same data and exit codes as alone."""

import os
import re
import signal
import subprocess
import unittest

from culm_program import (BAD_INPUT, DONE, OVERDAMPED, PATIENCE, POINTS_FAILED, PROGRAM, QUICK, SLOW,
                          STOPPED_EARLY, CulmTest, ranks_of, launcher)

LAUNCH = launcher(2)
# The launcher of MPICH 4.0.2 returns 0 instead of the exit code of ranks that a signal ended within
# a second of their start.
KEEPS_EXIT_CODE = "Open MPI" in subprocess.run([LAUNCH[0], "--version"], capture_output=True,
                                               text=True, check=False).stdout


class TwoRanks(CulmTest):
    def launch(self, *arguments):
        """Runs culm on two ranks to its end."""
        process = self.start(*LAUNCH, PROGRAM, *arguments)
        output, errors = process.communicate(timeout=PATIENCE)
        return process.returncode, output, errors

    def test_give_the_data_of_a_run_alone(self):
        self.write("s.toml", QUICK)
        code, output, errors = self.launch("run", "s.toml", "-o", "out")
        self.assertEqual(code, DONE, errors)
        self.assertEqual(output.count("sqrt(Y) = "), 1)
        self.assertIn("on 2 ranks\n", output)
        self.assertEqual(self.fits("out"), self.fits_of_undisturbed_run("s.toml"))

    def test_print_one_plan(self):
        self.write("s.toml", QUICK)
        code, output, _ = self.launch("run", "s.toml", "--dry-run")
        self.assertEqual(code, DONE)
        self.assertEqual(output.count("points         9 in "), 1)
        self.assertRegex(output, r"estimated cost [\d.e+-]+ core seconds, [\d.e+-]+ s on 2 ranks\n")

    def test_refuse_bad_input_with_one_message(self):
        code, output, errors = self.launch("run", "no.toml")
        self.assertEqual(code, BAD_INPUT)
        self.assertEqual(output, "")
        self.assertEqual(errors.count("culm: no.toml: cannot be read: No such file or directory\n"),
                         1)

    def test_report_failed_points_by_the_exit_code(self):
        self.write("s.toml", OVERDAMPED)
        code, output, _ = self.launch("run", "s.toml", "-o", "out", "-q")
        self.assertEqual(code, POINTS_FAILED)
        self.assertEqual(output.count("3 of 9 points failed:"), 1)

    def test_end_together_when_the_summary_cannot_be_written(self):
        # Only rank 0 has this error; the other rank must not wait for it for ever.
        self.write("s.toml", QUICK)
        (self.folder / "out/summary.json").mkdir(parents=True)
        code, _, errors = self.launch("run", "s.toml", "-o", "out", "-q")
        self.assertEqual(code, STOPPED_EARLY)
        self.assertEqual(errors.count("culm: out/summary.json: cannot be written"), 1)


class TwoRanksInterrupted(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", SLOW)
        self.launcher = self.start(*LAUNCH, PROGRAM, "run", "s.toml", "-o", "out", "-q")
        self.wait_for_points("out", 4)

    def kept_points(self, errors: str) -> int:
        said = re.findall(r"culm: stopped early; (\d+) of 24 points are computed and kept in out\. "
                          r"Continue with --resume\.\n", errors)
        self.assertEqual(len(said), 1, errors)
        return int(said[0])

    def assert_ended_with(self, code: int):
        if KEEPS_EXIT_CODE:
            self.assertEqual(self.launcher.returncode, code)

    def assert_resume_finishes(self, missing: int):
        """Resumes the run of two ranks on one rank; `missing` points must be computed."""
        self.assertFalse((self.folder / "out/study.h5").exists())
        finished = self.culm("run", "s.toml", "-o", "out", "--resume")
        self.assert_exit(finished, DONE)
        self.assertIn(f"{missing}/{missing} points", finished.stderr)
        self.assertEqual(self.fits("out"), self.fits_of_undisturbed_run("s.toml"))

    def assert_resume_keeps_points(self):
        """Resumes a run that did not report its number of kept points, which is at least four."""
        finished = self.culm("run", "s.toml", "-o", "out", "--resume")
        self.assert_exit(finished, DONE)
        computed = re.findall(r"(\d+)/\1 points", finished.stderr)
        self.assertLessEqual(int(computed[-1]) if computed else 0, 24 - 4)
        self.assertEqual(self.fits("out"), self.fits_of_undisturbed_run("s.toml"))

    def test_stop_both_after_a_signal_to_one_rank(self):
        os.kill(ranks_of(self.launcher.pid)[-1], signal.SIGTERM)
        _, errors = self.launcher.communicate(timeout=PATIENCE)
        self.assert_ended_with(STOPPED_EARLY)
        self.assert_resume_finishes(24 - self.kept_points(errors))

    def test_stop_with_the_exit_code_after_a_signal_that_mpirun_forwards(self):
        self.launcher.send_signal(signal.SIGUSR1)
        _, errors = self.launcher.communicate(timeout=PATIENCE)
        self.assert_ended_with(STOPPED_EARLY)
        self.assert_resume_finishes(24 - self.kept_points(errors))

    def test_keep_their_points_after_the_signal_that_ends_mpirun(self):
        # Open MPI forwards SIGTERM after a second and ends with its own exit code. The study may be
        # complete by then.
        self.launcher.send_signal(signal.SIGTERM)
        self.launcher.communicate(timeout=PATIENCE)
        if KEEPS_EXIT_CODE:
            self.assertNotEqual(self.launcher.returncode, DONE)
        self.assert_resume_keeps_points()

    def test_keep_the_points_of_both_after_the_death_of_one(self):
        os.kill(ranks_of(self.launcher.pid)[-1], signal.SIGKILL)
        self.launcher.communicate(timeout=PATIENCE)
        self.assertNotEqual(self.launcher.returncode, DONE)
        self.assertFalse((self.folder / "out/study.h5").exists())
        self.assert_resume_keeps_points()


if __name__ == "__main__":
    unittest.main()
