# SPDX-License-Identifier: BSD-3-Clause
"""How the command line treats points that kill their process and points that failed."""

import json
import shutil
import tempfile
import time
import unittest
from pathlib import Path

from fault_study import (BAD_INPUT, DONE, PATIENCE, POINTS_FAILED, ranks_of, culm, end_in_order,
                         kill, start)

# Two points of one or two seconds each, long enough to be killed during the first.
HEAVY = """
[stem]
spheres = 100
length_mm = 155.65
[integrator]
relative_tolerance = 1e-11
[vibration]
duration_s = 0.2
sample_interval_s = 0.01
[factors]
bond_damping = [3]
bond_youngs_modulus_gpa = [9, 10]
"""
LIMIT = 2


class CrashLimit(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory(prefix="culm-faults-")
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        (self.folder / "s.toml").write_text(HEAVY, encoding="utf-8")

    def starts(self) -> dict[int, int]:
        """The number of times that each unfinished point was begun."""
        looked = culm(self.folder, "archive", "status", "out", "--json", "-")
        if looked.returncode == BAD_INPUT:
            return {}
        found = json.loads(looked.stdout)
        return {entry["point"]: entry["times"] for entry in found["unfinished_starts"]}

    def die(self, ranks: int, options: list[str]):
        """Runs until another point has been begun, then kills the whole job."""
        before = self.starts()
        job = start(self.folder, "run", "s.toml", "-o", "out", "-q", *options, ranks=ranks)
        deadline = time.monotonic() + PATIENCE
        while self.starts() == before:
            self.assertLess(time.monotonic(), deadline)
            self.assertIsNone(job.poll(), "the run was over before it could be killed")
        workers = ranks_of(job.pid) if ranks > 1 else []
        for process in [*workers, job.pid]:
            kill(process)
        end_in_order(job, workers)

    def summary(self) -> dict:
        return json.loads((self.folder / "out/summary.json").read_text(encoding="utf-8"))

    def give_up_and_retry(self, ranks: int):
        limit = ["--crash-limit", str(LIMIT)]
        self.die(ranks, limit)
        deaths = 1
        while not self.starts() or max(self.starts().values()) < LIMIT:
            self.die(ranks, ["--resume", *limit])
            deaths += 1
            self.assertLess(deaths, 10)
        given_up = [point for point, times in self.starts().items() if times >= LIMIT]
        finished = culm(self.folder, "run", "s.toml", "-o", "out", "-q", "--resume", *limit,
                        ranks=ranks)
        self.assertEqual(finished.returncode, POINTS_FAILED, finished.stderr)
        failed = self.summary()["failed"]
        self.assertEqual([entry["point"] for entry in failed], given_up)
        self.assertEqual({entry["kind"] for entry in failed}, {"rank_died"})
        self.assertIn(f"died {LIMIT} times (--crash-limit {LIMIT}); --retry-failed tries it again",
                      failed[0]["reason"])
        # They are not tried again without --retry-failed.
        again = culm(self.folder, "run", "s.toml", "-o", "out", "-q", "--resume", *limit,
                     ranks=ranks)
        self.assertEqual(again.returncode, POINTS_FAILED, again.stderr)
        retried = culm(self.folder, "run", "s.toml", "-o", "out", "-q", "--resume",
                       "--retry-failed", *limit, ranks=ranks)
        self.assertEqual(retried.returncode, DONE, retried.stderr)
        self.assertEqual(self.summary()["failed"], [])

    def test_is_kept_by_a_run_alone_and_lifted_by_retry_failed(self):
        self.give_up_and_retry(ranks=1)

    @unittest.skipIf(shutil.which("mpirun") is None, "mpirun is missing")
    def test_is_kept_under_mpirun_and_lifted_by_retry_failed(self):
        self.give_up_and_retry(ranks=2)

    def test_retry_failed_needs_resume(self):
        refused = culm(self.folder, "run", "s.toml", "-o", "out", "--retry-failed")
        self.assertEqual(refused.returncode, BAD_INPUT)
        self.assertIn("--resume", refused.stderr)


if __name__ == "__main__":
    unittest.main()
