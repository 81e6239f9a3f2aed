# SPDX-License-Identifier: BSD-3-Clause
"""Full and read-only disks: the message is clear, and no computed point is lost."""

import os
import re
import resource
import subprocess
import unittest

from culm_program import BAD_INPUT, DONE, QUICK, STOPPED_EARLY, CulmTest

KEPT = re.compile(r"\nculm: stopped early; (\d+) of 9 points are computed and kept in (\S+)\. "
                  r"Continue with --resume\.\n$")


class FullDisk(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", QUICK)

    def assert_finishes(self, folder: str, missing: int):
        """Asserts that --resume computes only the missing points and completes the study."""
        finished = self.culm("run", "s.toml", "-o", folder, "--resume")
        self.assert_exit(finished, DONE)
        self.assertIn(f"{missing}/{missing} points", finished.stderr)
        self.assertEqual(self.fits(folder), self.fits_of_undisturbed_run("s.toml"))

    def test_stops_a_run_early_at_a_file_size_limit_and_resume_finishes(self):
        # Linux reports a file beyond the limit as EFBIG if SIGXFSZ is ignored.
        limit = 40_000
        stopped = self.culm(
            "run", "s.toml", "-o", "out", "-q",
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assert_exit(stopped, STOPPED_EARLY)
        self.assertEqual(stopped.stdout, "")
        self.assertRegex(stopped.stderr, r"^culm: rank 0: cannot write "
                                         r"out/journal/rank-00000\.culmj: File too large\n")
        self.assertEqual(stopped.stderr.count("\n"), 2, stopped.stderr)
        kept, folder = KEPT.search(stopped.stderr).groups()
        self.assertEqual((kept, folder), ("4", "out"))  # 8.2 kB each
        self.assert_finishes("out", 5)

    def mount(self, kilobytes: int) -> str:
        """An empty file system of that size; skips the test if none can be mounted."""
        (self.folder / "disk").mkdir()
        command = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", "disk"]
        if os.geteuid() != 0 or subprocess.run(command, cwd=self.folder, check=False,
                                               capture_output=True).returncode != 0:
            self.skipTest("a full disk needs the right to mount one")
        self.addCleanup(subprocess.run, ["umount", "disk"], cwd=self.folder, check=True)
        return "disk/out"

    def make_room(self):
        subprocess.run(["mount", "-o", "remount,size=10m", "disk"], cwd=self.folder, check=True)

    def test_stops_a_run_early_while_points_are_computed_and_resume_finishes(self):
        place = self.mount(40)
        stopped = self.culm("run", "s.toml", "-o", place, "-q")
        self.assert_exit(stopped, STOPPED_EARLY)
        self.assertRegex(stopped.stderr, r"^culm: rank 0: cannot write "
                                         r"disk/out/journal/rank-00000\.culmj: No space left on "
                                         r"device\n")
        kept = int(KEPT.search(stopped.stderr)[1])
        self.assertGreater(kept, 1)
        # Without free space the run makes no progress but loses nothing.
        again = self.culm("run", "s.toml", "-o", place, "-q", "--resume")
        self.assert_exit(again, STOPPED_EARLY)
        self.assertEqual(int(KEPT.search(again.stderr)[1]), kept)
        self.make_room()
        self.assert_finishes(place, 9 - kept)

    def test_keeps_the_journals_when_the_archive_is_written_and_resume_finishes(self):
        place = self.mount(120)  # 80 kB of journals fit, but not the archive as well
        stopped = self.culm("run", "s.toml", "-o", place, "-q")
        self.assert_exit(stopped, STOPPED_EARLY)
        self.assertRegex(stopped.stderr, r"^culm: .*study\.h5.*No space left on device.*\n"
                                         r"Nothing computed so far is lost\. Once the disk can be "
                                         r"written again, continue with --resume\.\n$")
        self.assertFalse((self.folder / place / "study.h5").exists())
        self.make_room()
        finished = self.culm("run", "s.toml", "-o", place, "--resume")
        self.assert_exit(finished, DONE)
        self.assertNotIn("points/s", finished.stderr)  # no point was missing
        self.assertEqual(self.fits(place), self.fits_of_undisturbed_run("s.toml"))

    def test_keeps_the_archive_if_the_summary_cannot_be_written(self):
        (self.folder / "out/summary.json").mkdir(parents=True)
        stopped = self.culm("run", "s.toml", "-o", "out", "-q")
        self.assert_exit(stopped, STOPPED_EARLY)
        self.assertEqual(stopped.stderr,
                         "culm: out/summary.json: cannot be written\n"
                         "Nothing computed so far is lost. Once the disk can be written again, continue "
                         "with --resume.\n")
        (self.folder / "out/summary.json").rmdir()
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "--resume"), DONE)


class ReadOnlyFolder(CulmTest):
    NOBODY = 65534

    def setUp(self):
        super().setUp()
        self.write("s.toml", QUICK)
        self.folder.chmod(0o755)
        (self.folder / "closed").mkdir(mode=0o555)

    def as_ordinary_user(self, *arguments):
        """Runs culm as an ordinary user, because root may write everywhere."""
        if os.geteuid() != 0:
            return self.culm(*arguments)
        try:
            return self.culm(*arguments, user=self.NOBODY, group=self.NOBODY, extra_groups=[])
        except PermissionError as error:
            self.skipTest(f"the program cannot be run by an ordinary user: {error}")

    def test_is_refused_before_any_work(self):
        self.assert_refused(
            self.as_ordinary_user("run", "s.toml", "-o", "closed"),
            "culm: cannot write to the folder closed: Permission denied; choose another one with "
            "-o\n")
        self.assert_refused(
            self.as_ordinary_user("run", "s.toml", "-o", "closed/out"),
            "culm: cannot create the folder closed/out: Permission denied; choose another one with "
            "-o\n")

    def test_is_refused_if_it_may_not_be_searched(self):
        (self.folder / "closed").chmod(0o000)
        self.addCleanup((self.folder / "closed").chmod, 0o700)
        for command, complaint in (
                (["run", "s.toml", "-o", "closed"],
                 "cannot write to the folder closed: Permission denied; choose another one with "
                 "-o"),
                (["reduce", "closed"], "cannot look for closed/study.h5: Permission denied")):
            finished = self.as_ordinary_user(*command)
            self.assert_exit(finished, BAD_INPUT)
            self.assertEqual(finished.stderr, f"culm: {complaint}\n")

    def test_is_refused_if_a_file_has_its_name(self):
        self.assert_refused(self.culm("run", "s.toml", "-o", "s.toml"),
                            "culm: cannot create the folder s.toml: Not a directory; choose "
                            "another one with -o\n")


if __name__ == "__main__":
    unittest.main()
