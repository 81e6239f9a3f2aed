# SPDX-License-Identifier: BSD-3-Clause
"""Signals and kill -9 during a run: computed points are kept, and resume finishes the run."""

import re
import signal
import unittest

from culm_program import BAD_INPUT, DONE, PROGRAM, SLOW, STOPPED_EARLY, CulmTest

POINTS = 24


class Interruption(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", SLOW)

    def interrupt(self, signal_number: int):
        """Sends a signal when two points are kept; returns exit code and standard error."""
        process = self.start(PROGRAM, "run", "s.toml", "-o", "out", "-q")
        self.wait_for_points("out", 2)
        process.send_signal(signal_number)
        _, errors = process.communicate()
        self.assertFalse((self.folder / "out/study.h5").exists())
        return process.returncode, errors

    def resume(self) -> int:
        """Finishes the study; returns the number of points that were computed."""
        finished = self.culm("run", "s.toml", "-o", "out", "--resume")
        self.assert_exit(finished, DONE)
        self.assertEqual(self.fits("out"), self.fits_of_undisturbed_run("s.toml"))
        return int(re.findall(r"(\d+)/\1 points", finished.stderr)[-1])

    def test_kill_9_loses_no_finished_point(self):
        self.assertEqual(self.interrupt(signal.SIGKILL)[0], -signal.SIGKILL)
        self.assert_exit(self.culm("reduce", "out"), BAD_INPUT)
        computed = self.resume()
        self.assertLessEqual(computed, POINTS - 2)
        self.assertGreater(computed, 0)

    def test_resumed_study_by_sundials_equals_an_undisturbed_one(self):
        self.write("s.toml", SLOW + "[integrator]\nmethod = \"sundials\"\n")
        self.assertEqual(self.interrupt(signal.SIGKILL)[0], -signal.SIGKILL)
        self.assertGreater(self.resume(), 0)

    def test_stop_signals_end_the_run_in_order(self):
        code, errors = self.interrupt(signal.SIGTERM)
        self.assertEqual(code, STOPPED_EARLY)
        said = re.fullmatch(r"culm: stopped early; (\d+) of 24 points are computed and kept in "
                            r"out\. Continue with --resume\.\n", errors)
        self.assertIsNotNone(said, errors)
        self.assertGreaterEqual(int(said[1]), 2)
        self.assertEqual(self.resume(), POINTS - int(said[1]))

    def test_study_that_was_stopped_cannot_be_reduced_yet(self):
        for number in (signal.SIGINT, signal.SIGUSR1, signal.SIGUSR2):
            self.assertEqual(self.interrupt(number)[0], STOPPED_EARLY, number)
            self.assert_refused(
                self.culm("reduce", "out"),
                "culm: out: the study is not complete; run `culm run STUDY.toml -o out --resume` "
                "first\n")
            self.assert_refused(
                self.culm("run", "s.toml", "-o", "out"),
                "culm: out already holds this study, whole or in part; add --resume to compute "
                "only what is missing, or choose another folder with -o\n")
            (self.folder / "out").rename(self.folder / f"out-{number}")

    def test_second_run_in_the_same_folder_waits_for_the_first(self):
        self.write("s.toml", SLOW + "[integrator]\nmethod = \"sundials\"\nrelative_tolerance = 1e-9\n")
        process = self.start(PROGRAM, "run", "s.toml", "-o", "out", "-q")
        self.wait_for_points("out", 1)
        process.send_signal(signal.SIGSTOP)  # longer than it takes to announce the wait
        second = self.start(PROGRAM, "run", "s.toml", "-o", "out", "--resume", "-q")
        self.assertEqual(second.stderr.readline(),
                         "culm: another process still works in out; waiting for it, 30 s at most\n")
        process.send_signal(signal.SIGCONT)
        process.communicate()
        self.assertEqual(process.returncode, DONE)
        second.communicate()
        self.assertEqual(second.returncode, DONE)


if __name__ == "__main__":
    unittest.main()
