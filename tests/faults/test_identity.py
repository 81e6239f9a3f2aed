# SPDX-License-Identifier: BSD-3-Clause
"""Final tables are byte-identical for 1, 2, 4 and 8 ranks and do not depend on interruptions or on
changes of the number of ranks."""

import random
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from fault_study import (DONE, STUDY, ranks_of, culm, end_in_order, kill_at_random, start,
                         verify)
from kill_study import contents, tables

RANKS = (1, 2, 4, 8)


class FinalTables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        place = tempfile.TemporaryDirectory(prefix="culm-faults-")
        cls.addClassCleanup(place.cleanup)
        cls.folder = Path(place.name)
        (cls.folder / "s.toml").write_text(STUDY, encoding="utf-8")
        finished = culm(cls.folder, "run", "s.toml", "-o", "whole", "-q")
        if finished.returncode != DONE:
            raise RuntimeError(finished.stderr)
        cls.expected = cls.everything("whole")

    @classmethod
    def everything(cls, study: str):
        """Every dataset and the fits, byte for byte."""
        return tables(cls.folder, study), contents(cls.folder, study)

    def interrupt(self, study: str, ranks: int, chance: random.Random):
        """Begins or resumes, then kills a rank or the job, or asks it to stop."""
        job = start(self.folder, "run", "s.toml", "-o", study, "-q", "--resume", "--crash-limit",
                    "0", ranks=ranks)
        delay = chance.uniform(0.05, 0.8)
        if chance.random() < 0.7:
            kill_at_random(job, chance, ranks, delay)
            return
        try:
            job.wait(timeout=delay)
        except subprocess.TimeoutExpired:  # still at work
            workers = ranks_of(job.pid) if ranks > 1 else []
            job.send_signal(chance.choice((signal.SIGUSR1, signal.SIGUSR2)))
            end_in_order(job, workers)

    def assert_identical(self, study: str, ranks: int):
        finished = culm(self.folder, "run", "s.toml", "-o", study, "-q", "--resume",
                        "--crash-limit", "0", ranks=ranks)
        self.assertEqual(finished.returncode, DONE, finished.stderr)
        self.assertEqual(verify(self.folder, study)["exit_code"], DONE)
        self.assertEqual(self.everything(study), self.expected, study)

    def test_do_not_depend_on_the_number_of_ranks(self):
        for ranks in RANKS[1:]:
            self.assert_identical(f"ranks-{ranks}", ranks)

    def test_do_not_depend_on_kills_and_stops(self):
        chance = random.Random(5)
        for ranks in RANKS:
            study = f"disturbed-{ranks}"
            for _ in range(chance.randint(1, 3)):
                self.interrupt(study, ranks, chance)
            self.assert_identical(study, ranks)

    def test_do_not_depend_on_numbers_of_ranks_that_take_turns(self):
        chance = random.Random(6)
        for ranks in chance.sample(RANKS, len(RANKS)):
            self.interrupt("turns", ranks, chance)
        self.assert_identical("turns", 2)


if __name__ == "__main__":
    unittest.main()
