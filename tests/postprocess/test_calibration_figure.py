# SPDX-License-Identifier: BSD-3-Clause
"""The motion figure shows the numbers of the prediction table; checked on matplotlib's objects."""
import contextlib
import io
import json
import shutil
import tempfile
import unittest
from pathlib import Path

import calibration_figure
import synthetic_results
from command_results import CalibrationError, CalibrationResults
from figure_style import FigureSkipped
from matplotlib.patches import StepPatch


class CalibrationFigure(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        good = {"measurement": "S1", "fit": {"rmse_mm": 0.1, "noise_mm": 0.05}}
        self.write([good, {"measurement": "S2", "failure": "no motion"}])
        (self.folder / "predictions").mkdir()
        (self.folder / "predictions/001.csv").write_text(
            "time_s,measured h=50mm,predicted h=50mm,measured h=100mm,predicted h=100mm\n"
            "0,1,1,5,4.5\n0.1,0.5,0.4,,2\n0.2,-1,-1,-3,-3.5\n", "utf-8")

    def write(self, stems):
        (self.folder / "calibration.json").write_text(
            json.dumps({"format": "culm-calibration", "version": 1, "stems": stems}), "utf-8")

    def test_shows_the_row_that_moves_most_and_its_residual(self):
        figure = calibration_figure.motion_figure(CalibrationResults(self.folder))
        upper, lower = figure.axes
        self.assertEqual(list(upper.lines[1].get_ydata()), [4.5, 2.0, -3.5])
        left = lower.lines[0].get_ydata()
        self.assertEqual([left[0], left[2]], [0.5, 0.5])
        self.assertNotEqual(left[1], left[1])  # a gap

    def test_skips_a_failed_stem_with_its_reason(self):
        with self.assertRaisesRegex(FigureSkipped, "no motion"):
            calibration_figure.motion_figure(CalibrationResults(self.folder), 2)

    def test_shows_all_stems_of_a_population_and_the_range_of_90_percent(self):
        shutil.rmtree(self.folder / "predictions")
        synthetic_results.write_calibration(self.folder, ("A", "B", "C"))
        results = CalibrationResults(self.folder)
        modulus, damping = calibration_figure.population_figure(results).axes
        for axes in (modulus, damping):
            stairs, = (patch for patch in axes.patches if isinstance(patch, StepPatch))
            self.assertEqual(sum(stairs.get_data().values), 3)
        self.assertEqual([line.get_xdata()[0] for line in damping.lines], [0.9, 1.1])
        names = ["population", *(f"motion-00{number}" for number in (1, 2, 3, 4))]
        self.assertEqual(list(calibration_figure.figures_of(results)), names)

    def test_writes_the_figure_and_prints_its_path(self):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            code = calibration_figure.main([str(self.folder)])
        self.assertEqual(code, 0)
        self.assertTrue(Path(printed.getvalue().strip()).is_file())

    def test_refuses_another_folder_in_one_sentence(self):
        with self.assertRaises(CalibrationError):
            CalibrationResults(self.folder / "predictions")


if __name__ == "__main__":
    unittest.main()
