# SPDX-License-Identifier: BSD-3-Clause
"""A wall clock that jumps by years during a run changes only the dates in the archive, because
intervals are measured with the monotonic clock."""

import json
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from fault_study import (DONE, LONG_STUDY, PATIENCE, PROGRAM, culm, journal_bytes, launcher)

LIBRARIES = sorted(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))
# Jumps ahead, far back, and ahead by more than any lease, heartbeat or walltime.
JUMPS = ("+400d", "-9000d", "+9000d")


@unittest.skipUnless(LIBRARIES, "libfaketime (package faketime) is missing")
class Jumps(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory(prefix="culm-faults-")
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        (self.folder / "s.toml").write_text(LONG_STUDY, encoding="utf-8")
        self.clock = self.folder / "clock"
        self.clock.write_text("+0d\n", encoding="utf-8")
        whole = culm(self.folder, "run", "s.toml", "-o", "whole", "-q")
        self.assertEqual(whole.returncode, DONE, whole.stderr)

    def run_with_jumps(self, start: list[str]):
        fake = ["env", f"LD_PRELOAD={LIBRARIES[0]}", f"FAKETIME_TIMESTAMP_FILE={self.clock}",
                "FAKETIME_NO_CACHE=1", "FAKETIME_DONT_FAKE_MONOTONIC=1"]
        started = time.monotonic()
        process = subprocess.Popen(
            [*start, *fake, PROGRAM, "run", "s.toml", "-o", "out", "-q", "--walltime", "30min"],
            cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True)
        jump = 0
        size = 0
        while process.poll() is None:
            self.assertLess(time.monotonic() - started, PATIENCE)
            written = journal_bytes(self.folder / "out")
            if written > size + 20_000:  # a few points later
                self.clock.write_text(JUMPS[jump % len(JUMPS)] + "\n", encoding="utf-8")
                size = written
                jump += 1
            time.sleep(0.002)
        output = process.communicate()[0]
        self.assertEqual(process.returncode, DONE, output)
        self.assertGreaterEqual(jump, len(JUMPS))
        return time.monotonic() - started

    def assert_only_dates_differ(self, seconds: float):
        info = culm(self.folder, "archive", "info", "out", "--json", "-")
        facts = json.loads(info.stdout)["archive"]["provenance"]
        # The jumps had an effect: by its dates the study ended years before or after it began.
        self.assertGreater(abs(int(facts["end"][:4]) - int(facts["start"][:4])), 0)
        # They had no effect on the duration that it measured.
        self.assertLess(float(facts["wall_s"]), seconds)
        self.assertEqual((self.folder / "out/fits.csv").read_bytes(),
                         (self.folder / "whole/fits.csv").read_bytes())

    def test_do_not_disturb_a_run(self):
        self.assert_only_dates_differ(self.run_with_jumps([]))

    def test_do_not_disturb_two_ranks(self):
        self.assert_only_dates_differ(
            self.run_with_jumps(launcher(2)))


if __name__ == "__main__":
    unittest.main()
