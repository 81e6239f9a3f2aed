# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that a fuzzer found, a mapping and its table in each, give a measurement or a refusal."""
import os
import tarfile
import unittest
from pathlib import Path

import import_recording
from recording_files import RecordingFiles

CORPUS = Path(__file__).resolve().parents[1] / "fuzz/corpus/recording.tar.gz"
BORDER = b"\n====\n"


class HostileRecordings(RecordingFiles):
    def test_give_a_result_or_a_refusal(self):
        count = 0
        with tarfile.open(CORPUS) as archive:
            for member in archive.getmembers():
                content = archive.extractfile(member).read() if member.isfile() else b""
                mapping, border, table = content.partition(BORDER)
                if not border:
                    continue
                count += 1
                mapping = self.file("mapping.toml", mapping + b"\n")
                with self.subTest(member.name):
                    code, _, err = self.ran(
                        import_recording, mapping, self.folder / "out", "--recording",
                        str(self.file("recording.csv", table)), "--culm-track",
                        os.environ.get("CULM_TRACK", "culm-track"))
                    self.assertIn(code, (0, 2))
                    self.assertEqual(code == 2, err.startswith("culm: ") and "note" not in err[:12])
        self.assertGreater(count, 50)


if __name__ == "__main__":
    unittest.main()
