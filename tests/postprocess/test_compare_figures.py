# SPDX-License-Identifier: BSD-3-Clause
"""The figures of culm compare show the numbers of comparison.json; checked on their objects."""
import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import compare_figures
from command_results import Comparison, ComparisonError
from figure_style import FigureSkipped
from synthetic_results import backbone


def estimate(value):
    return {"value": value, "stderr": 0.01}


def rung(names, ratio, decay):
    where = {
        "by_height": [{"height_mm": 50.0, "rms_over_noise": ratio},
                      {"height_mm": 100.0, "rms_over_noise": 2.0 * ratio}],
        "spectrum": {"frequency_hz": [0.0, 10.0, 20.0], "power_over_noise": [1.0, ratio, None],
                     "mode_frequencies_hz": [10.0]},
        "backbone": {"measured": backbone((8.0, 0.03), (2.0, 0.02)),
                     "modelled": backbone((8.0, -decay / 6.3))},
        "banding": {"heights": [{"height_mm": 50.0, "measured": estimate(-0.15),
                                 "modelled": estimate(decay)},
                                {"height_mm": 100.0, "measured": None, "modelled": None}]},
        "residual_map": {"time_s": [0.0, 0.001, 0.002], "height_mm": [50.0, 100.0],
                         "residual_mm": [[0.1, -0.2], [None, 0.3], [0.0, 0.1]]},
    }
    return {"model": names, "added": names[1:], "rmse_mm": 0.04 * ratio, "rmse_over_noise": ratio,
            "where": where, **({"gain": True} if len(names) > 1 else {})}


class CompareFigures(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        self.write(rung(["baseline"], 5.0, -0.17), rung(["baseline", "drag"], 1.0, -0.2),
                   {"model": ["baseline", "drag", "taper"], "failure": "no"})

    def write(self, *ladder):
        (self.folder / "comparison.json").write_text(
            json.dumps({"format": "culm-comparison", "version": 1, "measurement": "T2",
                        "noise_mm": 0.04, "ladder": ladder}), "utf-8")

    def figure(self, name):
        return compare_figures.FIGURES[name](Comparison(self.folder))

    def test_ladder_shows_every_model_that_could_be_fitted(self):
        axes = self.figure("ladder").axes[0]
        self.assertEqual(list(axes.lines[0].get_xdata()), [5.0, 1.0])
        self.assertEqual([label.get_text() for label in axes.get_yticklabels()],
                         ["baseline", "drag: a gain"])

    def test_maps_show_residuals_on_one_scale(self):
        first, second = self.figure("residuals").axes[:2]
        meshes = [axes.collections[0] for axes in (first, second)]
        self.assertEqual(meshes[0].get_clim(), meshes[1].get_clim())
        self.assertEqual(meshes[0].get_array().count(), 5)  # one of six readings is missing

    def test_spectra_carry_the_mode(self):
        axes = self.figure("spectrum").axes[0]
        self.assertEqual(list(axes.lines[0].get_ydata())[:2], [1.0, 5.0])
        self.assertEqual([text.get_text() for text in axes.texts], ["mode 1"])

    def test_amplitude_shows_the_decay(self):
        axes = self.figure("amplitude").axes[1]
        measured, baseline, drag = axes.containers
        self.assertEqual(list(measured.lines[0].get_xdata()), [8.0, 2.0])
        self.assertEqual(list(baseline.lines[0].get_ydata()), [0.17 / 6.3])
        self.assertEqual(list(drag.lines[0].get_ydata()), [0.2 / 6.3])

    def test_heights_show_residuals_and_decay_along_the_stem(self):
        residual, decay = self.figure("heights").axes
        self.assertEqual(list(residual.lines[0].get_xdata()), [5.0, 10.0])
        self.assertEqual(list(decay.lines[0].get_xdata()), [-0.17])

    def test_have_no_ladder_for_one_model(self):
        self.write(rung(["baseline"], 5.0, -0.17))
        with self.assertRaises(FigureSkipped):
            self.figure("ladder")

    def test_are_written_by_one_command(self):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            self.assertEqual(compare_figures.main([str(self.folder)]), 0)
        for line in printed.getvalue().splitlines():
            self.assertGreater(Path(line).stat().st_size, 1000)
        self.assertEqual(len(printed.getvalue().splitlines()), 5)

    def test_refuse_another_file_in_one_sentence(self):
        (self.folder / "comparison.json").write_text("{}", "utf-8")
        with self.assertRaisesRegex(ComparisonError, "not written by this version"):
            Comparison(self.folder)
        with contextlib.redirect_stderr(io.StringIO()) as complaint:
            self.assertEqual(compare_figures.main([str(self.folder / "nothing")]), 2)
        self.assertEqual(complaint.getvalue().count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
