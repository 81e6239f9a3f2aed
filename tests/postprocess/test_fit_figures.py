# SPDX-License-Identifier: BSD-3-Clause
"""The laboratory figures show the numbers of fit.json; checked on matplotlib's objects."""
import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import fit_figures
import numpy as np
import synthetic_results
from figure_style import FigureSkipped
from command_results import FitError, FitResults
from matplotlib.patches import StepPatch


def estimate(value):
    return {"value": value, "stderr": 0.01, "interval": [value - 0.02, value + 0.02]}


def sample(mean):
    return {"mean": mean, "standard_deviation": 0.1}


def stem(number):
    heights = [{"height_mm": 50.0 * j, "b1_per_cycle": estimate(-0.1 * number - 0.01 * j)}
               for j in (1, 2)]
    return {"measurement": f"S{number}", "length_mm": 150.0,
            "largest_deflection_mm": 20.0, "aspect_ratio": 50.0 + number,
            "b1_per_cycle": estimate(-0.1 * number), "b2_hz": estimate(60.0 + number),
            "heights": [*heights, {"height_mm": 120.0, "failure": "no"}]}


class FitFigures(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        self.write(stems=[stem(1), stem(2), stem(3)],
                   population={"b1_per_cycle": sample(-0.2), "b2_hz": sample(62.0)})
        (self.folder / "normalised").mkdir()
        (self.folder / "normalised/001.csv").write_text(
            "cycles,h=50mm,h=100mm\n-0.1,0.3,1\n0,0.3,1\n0.5,-0.2,\n1,0.1,0.6\n", "utf-8")

    def write(self, **content):
        (self.folder / "fit.json").write_text(
            json.dumps({"format": "culm-fit", "version": 1, **content}), "utf-8")

    def test_histories_show_every_height_over_cycles(self):
        in_time, axes, _ = fit_figures.histories_figure(FitResults(self.folder)).axes
        # b2 = 61 Hz and a largest deflection of 20 mm revert the normalisation.
        self.assertAlmostEqual(in_time.lines[0].get_xdata()[2], 500.0 / 61.0)
        self.assertAlmostEqual(in_time.lines[0].get_ydata()[2], -4.0)
        self.assertEqual(list(axes.lines[0].get_xdata()), [-0.1, 0, 0.5, 1])
        self.assertEqual(list(axes.lines[0].get_ydata()), [0.3, 0.3, -0.2, 0.1])
        self.assertNotEqual(axes.lines[1].get_ydata()[2], axes.lines[1].get_ydata()[2])  # a gap

    def test_population_shows_both_histograms(self):
        figure = fit_figures.population_figure(FitResults(self.folder))
        for axes, mean, published in zip(figure.axes, (-0.2, 62.0), (-0.46, 64.6)):
            marked = axes.containers[0].lines[0]
            self.assertEqual(marked.get_xdata()[0], published)
            stairs, = (patch for patch in axes.patches if isinstance(patch, StepPatch))
            self.assertEqual(list(stairs.get_data().values), [1, 1, 1])
            self.assertEqual(axes.lines[0].get_xdata()[0], mean)

    def test_banding_shows_fitted_heights_and_aspect_ratios(self):
        left, right = fit_figures.banding_figure(FitResults(self.folder)).axes
        self.assertEqual(len(left.containers), 3)
        self.assertIn(-0.46, [axes.get_ydata()[0] for axes in left.lines])
        line = left.containers[1].lines[0]
        self.assertEqual([round(y, 6) for y in line.get_ydata()], [-0.21, -0.22])
        self.assertEqual([round(x, 6) for x in line.get_xdata()], [0.333333, 0.666667])
        self.assertEqual(list(right.containers[0].lines[0].get_xdata()), [51.0, 52.0, 53.0])

    def test_backbone_shows_windows_and_laws(self):
        self.assertRaises(FigureSkipped, fit_figures.backbone_figure, FitResults(self.folder))
        synthetic_results.write(self.folder, "fit.json",
                                synthetic_results.fit(synthetic_results.backbone_with_laws()))
        frequency, damping, *of_mode_2 = fit_figures.backbone_figure(FitResults(self.folder)).axes
        for axes, expected, error in ((frequency, [76.0, 79.0, 79.75], 0.01),
                                      (damping, [0.031, 0.022, 0.019], 0.001)):
            windows, = axes.containers
            self.assertEqual(list(windows.lines[0].get_xdata()), [10.0, 5.0, 2.5])
            np.testing.assert_allclose(np.array(windows.lines[0].get_ydata(), float), expected)
            bar = windows.lines[2][0].get_segments()[0]
            self.assertAlmostEqual(bar[1][1] - bar[0][1], 2.0 * 1.96 * error)
            law = axes.lines[0]  # runs through the windows at its ends
            np.testing.assert_allclose(law.get_xdata()[[0, -1]], [2.5, 10.0])
            np.testing.assert_allclose(law.get_ydata()[[0, -1]], [expected[2], expected[0]])
        self.assertIn("c/A + ζ0 + ζ1 A^p, p = 1", damping.get_legend().texts[1].get_text())
        self.assertEqual([len(axes.get_legend().texts) for axes in of_mode_2], [1, 1])
        strain = synthetic_results.backbone_with_laws()[:1]
        strain[0]["is_strain"] = True
        synthetic_results.write(self.folder, "fit.json", synthetic_results.fit(strain))
        of_strain = fit_figures.backbone_figure(FitResults(self.folder)).axes
        self.assertEqual([axes.get_xlabel() for axes in of_strain], ["amplitude, mm/m"] * 2)

    def test_are_left_out_for_one_stem(self):
        self.write(stems=[stem(1)], population=None)
        results = FitResults(self.folder)
        for make_figure in (fit_figures.population_figure, fit_figures.banding_figure):
            self.assertRaises(FigureSkipped, make_figure, results)

    def test_are_refused_for_another_folder(self):
        self.write(stems=[])
        (self.folder / "fit.json").write_text("{}", "utf-8")
        self.assertRaises(FitError, FitResults, self.folder)
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(fit_figures.main([str(self.folder / "nowhere")]), 2)
        self.assertIn("fit.json", said.getvalue())

    def test_program_writes_and_names_the_files(self):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            self.assertEqual(fit_figures.main([str(self.folder), "-o", str(self.folder / "a")]), 0)
        for name in ("histories", "population", "banding"):
            self.assertTrue((self.folder / "a" / f"{name}.png").stat().st_size > 5000)
            self.assertIn(f"{name}.png", said.getvalue())


if __name__ == "__main__":
    unittest.main()
