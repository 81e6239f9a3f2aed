#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The mappings in config/measurements import the files of the programs that they name."""
import csv
import os
import re
import shutil
import sys
import tomllib
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, CulmTest

SOURCE = Path(__file__).resolve().parents[2]
MAPPINGS = SOURCE / "config/measurements"
RECORDINGS = SOURCE / "tests/data/recordings"
RELEASE_S = 0.094   # of the recordings of the beam, as they were computed
EXPORTS = {"tracker_text": ("tracker_export.txt", 1), "dic_dice": ("dice_point.txt", 1),
           "dic_pyidi": ("pyidi_displacements.npy", 2), "matlab": ("matlab_recording.mat", 2),
           "laser": ("laser.csv", 1)}


class ReadyMappings(CulmTest):
    def imported(self, name: str, recording: str):
        finished = self.culm("import", MAPPINGS / f"{name}.toml", "--recording",
                             RECORDINGS / recording, "-o", name,
                             env={**os.environ, "CULM_PYTHON": sys.executable})
        self.assert_exit(finished, DONE)
        with open(self.folder / name / "deflection.csv", encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
        return header, [[float(cell) for cell in row] for row in rows]

    def test_import_displacements_of_every_program(self):
        for name, (recording, heights) in EXPORTS.items():
            with self.subTest(name):
                header, rows = self.imported(name, recording)
                self.assertEqual(len(header), 1 + heights)
                self.assertEqual(len(rows), 200)
                self.assertAlmostEqual(rows[0][0], -RELEASE_S, delta=0.01)
                swing = max(row[-1] for row in rows) - min(row[-1] for row in rows)
                self.assertAlmostEqual(swing, 20.0 * 1.886, delta=0.3)

    def test_import_a_project_of_tracker(self):
        header, rows = self.imported("tracker_trk", "tracker.trk")
        self.assertEqual(header, ["time_s", "h=150mm"])
        self.assertAlmostEqual(rows[0][1], 20.0, delta=0.2)  # as it was made

    def test_import_an_accelerometer_that_calibrate_takes(self):
        header, rows = self.imported("accelerometer", "accelerometer.csv")
        self.assertEqual(header, ["time_s", "acc_g"])
        self.assertEqual((rows[0], len(rows)), ([0.0, 0.4142], 400))

    def test_refuses_a_missing_marker_file(self):
        finished = self.culm("import", MAPPINGS / "c3d.toml", "-o", "markers")
        self.assertEqual(finished.returncode, BAD_INPUT)
        self.assertIn("capture.c3d: cannot be read: No such file", finished.stderr)


class Proposal(CulmTest):
    def test_leads_from_an_accelerometers_table_to_a_measurement(self):
        shutil.copy(RECORDINGS / "accelerometer.csv", self.folder)
        self.assert_exit(self.culm("import", "accelerometer.csv", "-o", "strip"), DONE)
        mapping = self.folder / "strip/import.toml"
        incomplete = self.culm("import", mapping, "-o", "strip")
        self.assertEqual(incomplete.returncode, BAD_INPUT)
        self.assertIn("length_mm", incomplete.stderr)
        text = mapping.read_text("utf-8")
        for key, value in {"height_mm": "140", "length_mm": "150", "density_kg_m3": "2700",
                           "diameter_mm": "2", "mass_g": "5"}.items():
            text = re.sub(rf"(?m)^# ?{key} = *", f"{key} = {value} ", text, count=1)
        mapping.write_text(text, "utf-8")
        self.assertEqual(tomllib.loads(text)["sensor"][0]["quantity"], "acceleration")
        self.assert_exit(self.culm("import", mapping, "-o", "strip"), DONE)
        stem = tomllib.loads((self.folder / "strip/stem.toml").read_text("utf-8"))
        self.assertEqual(stem["release"]["kind"], "moving")
        self.assertEqual(stem["sensor"][0]["mass_g"], 5)


if __name__ == "__main__":
    sys.argv = sys.argv[:1]
    unittest.main()
