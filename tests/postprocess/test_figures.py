# SPDX-License-Identifier: BSD-3-Clause
"""The figures show the study's numbers; checked on matplotlib's objects, not on pixels."""
import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import figures
import numpy as np
import synthetic_results
from culm.archive import Study, StudyError
from figure_style import FigureSkipped
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.patches import StepPatch
from synthetic_study import Synthetic, write_summary


class FigureTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def open(self, **options):
        self.truth = Synthetic(**options)
        study = Study(self.truth.write(self.folder))
        self.addCleanup(study.close)
        return study

    def change_summary(self, change):
        summary = self.truth.summary()
        change(summary["regression"])
        write_summary(self.folder, summary)


def labels_of(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


class Regression(FigureTest):
    def test_points_are_the_fits_coloured_by_the_other_factor(self):
        figure = figures.regression_figure(self.open())
        done = self.truth.is_completed
        root = np.sqrt(1e9 * self.truth.modulus_gpa)[done]
        left, right = figure.axes[0].collections[0], figure.axes[1].collections[0]
        np.testing.assert_array_equal(
            left.get_offsets(), np.column_stack([self.truth.frequency[done], root])
        )
        np.testing.assert_array_equal(left.get_array(), self.truth.damping[done])
        np.testing.assert_array_equal(
            right.get_offsets(),
            np.column_stack([-self.truth.decay_per_cycle[done], self.truth.damping[done]]),
        )
        # The file has GPa. They are converted to Pa and back, with one rounding each.
        np.testing.assert_allclose(right.get_array(), self.truth.modulus_gpa[done], rtol=1e-15)

    def test_lines_are_the_fitted_and_the_published_law(self):
        figure = figures.regression_figure(self.open())
        entries = self.truth.summary()["regression"]
        cases = (
            (figure.axes[0], entries["sqrt_youngs_modulus"], 1.0, (91.4, 574.3)),
            (figure.axes[1], entries["bond_damping"], -1.0, (2.5, -261.4)),
        )
        for axes, entry, sign, (intercept, slope) in cases:
            fitted, published = axes.lines
            b = sign * fitted.get_xdata()
            np.testing.assert_array_equal(
                fitted.get_ydata(), entry["intercept"] + entry["slope"] * b
            )
            np.testing.assert_array_equal(published.get_ydata(), intercept + slope * b)
            drawn = axes.collections[0].get_offsets()[:, 0]
            self.assertLess(fitted.get_xdata()[0], drawn.min())
            self.assertGreater(fitted.get_xdata()[1], drawn.max())

    def test_the_equations_are_in_the_panels(self):
        figure = figures.regression_figure(self.open())
        entry = self.truth.summary()["regression"]["sqrt_youngs_modulus"]
        ours, published = labels_of(figure.axes[0])
        self.assertIn(f"{entry['slope']:.4g} $b_2$", ours)
        self.assertIn(f"{entry['adjusted_r2']:.5f}, $n$ = 10", ours)
        self.assertIn("574.3 $b_2$ + 91.4", published)
        self.assertIn("−261.4 $b_1$ + 2.5", labels_of(figure.axes[1])[1])
        self.assertEqual(figure._suptitle.get_text(), "law schramm2019; fit window 0.1 s")

    def test_the_lower_panels_show_the_residuals_of_the_fitted_law(self):
        figure = figures.regression_figure(self.open())
        entry = self.truth.summary()["regression"]["bond_damping"]
        done = self.truth.is_completed
        damping, decay = self.truth.damping[done], self.truth.decay_per_cycle[done]
        expected = (damping - entry["intercept"] - entry["slope"] * decay) / 2.0  # % of β = 200
        drawn = figure.axes[3].collections[0].get_offsets()
        # Differences of numbers near 200 have rounding errors of about 1e-14 of these numbers.
        np.testing.assert_allclose(drawn[:, 1], expected, rtol=0.0, atol=1e-11)

    def test_an_impossible_regression_gives_its_reason_and_the_published_law(self):
        study = self.open(moduli_gpa=(4.0,), failed_point=None, missing_point=None)
        reason = "every point has the same Y."
        self.change_summary(lambda r: r.update(sqrt_youngs_modulus={"reason": reason}))
        figure = figures.regression_figure(study)
        self.assertEqual(len(figure.axes[0].lines), 1)
        self.assertIn(reason, figure.axes[2].texts[0].get_text().replace("\n", " "))
        bars = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
        self.assertEqual([bar.get_ylabel() for bar in bars], ["Bond damping β (–)"])

    def test_other_factors_are_named(self):
        length = {"length_mm": ("mm", np.linspace(150.0, 160.0, 12))}
        study = self.open(extra_factors=length)
        heading = figures.regression_figure(study)._suptitle.get_text()
        self.assertTrue(heading.endswith("also varied: length_mm"))

    def test_the_published_laws_are_not_those_of_another_stem(self):
        study = self.open(is_published_stem=False)
        for draw in (figures.regression_figure, figures.residual_figure):
            for axes in draw(study).axes[:2]:
                self.assertTrue(all("this study" in label for label in labels_of(axes)))

    def test_a_malformed_summary_is_refused(self):
        study = self.open()
        self.change_summary(lambda r: r["bond_damping"].pop("slope"))
        with self.assertRaisesRegex(StudyError, "regression of 'bond_damping' lacks 'slope'"):
            figures.regression_figure(study)


class Residuals(FigureTest):
    def steps_of(self, axes):
        return [patch for patch in axes.patches if isinstance(patch, StepPatch)]

    def test_bars_are_the_histogram_of_the_residuals(self):
        figure = figures.residual_figure(self.open())
        for axes, key in zip(figure.axes, ("sqrt_youngs_modulus", "bond_damping")):
            percent = self.truth.residuals_percent(key)
            values, edges, _ = self.steps_of(axes)[0].get_data()
            counts, expected = np.histogram(percent, bins="auto")
            self.assertEqual(values.tolist(), counts.tolist())
            np.testing.assert_allclose(edges, expected, rtol=1e-9)

    def test_the_published_law_is_drawn_with_every_point(self):
        figure = figures.residual_figure(self.open())
        for axes in figure.axes:
            values, edges, _ = self.steps_of(axes)[1].get_data()
            self.assertEqual(values.sum(), 10)
            np.testing.assert_allclose(np.diff(edges), np.diff(edges)[0], rtol=1e-9)

    def test_a_published_law_of_other_stems_is_mentioned_but_not_drawn(self):
        figure = figures.residual_figure(self.open(frequency_factor=2.0))
        self.assertEqual(len(self.steps_of(figure.axes[0])), 1)
        self.assertIn("not shown", labels_of(figure.axes[0])[1])
        self.assertEqual(len(self.steps_of(figure.axes[1])), 2)

    def test_an_impossible_regression_gives_its_reason(self):
        study = self.open()
        self.change_summary(lambda r: r.update(bond_damping={"reason": "too few points."}))
        figure = figures.residual_figure(study)
        self.assertEqual(len(figure.axes[1].patches), 0)
        self.assertIn("too few points", figure.axes[1].texts[0].get_text())


class TipHistory(FigureTest):
    def curves(self, axes):
        """Histories and fits, in pairs; the last line is the axis at zero."""
        return axes.lines[0:-1:2], axes.lines[1:-1:2]

    def test_histories_are_those_of_fig_7(self):
        figure = figures.tip_history_figure(self.open(failed_point=None, missing_point=None))
        # Points: β slow (25, 100, 150, 200), Y fast (1, 5, 10 GPa).
        for axes, points in zip(figure.axes, ([6, 7, 8], [2, 5, 11])):
            histories, _ = self.curves(axes)
            self.assertEqual(len(histories), 3)
            for line, point in zip(histories, points):
                tip = self.truth.tip(point)
                np.testing.assert_array_equal(line.get_xdata(), 1e3 * self.truth.time)
                np.testing.assert_array_equal(line.get_ydata(), tip / tip[0])
        labels = labels_of(figure.axes[0])
        expected = ["$Y$ = 1 GPa", "$Y$ = 5 GPa", "$Y$ = 10 GPa", "Eq. 1, fitted"]
        self.assertEqual(labels, expected)
        self.assertEqual(figure.axes[0].get_title(), "β = 150")
        self.assertEqual(labels_of(figure.axes[1])[:3], ["β = 25", "β = 100", "β = 200"])

    def test_fits_lie_on_histories_that_follow_eq_1(self):
        figure = figures.tip_history_figure(self.open(failed_point=None, missing_point=None))
        for axes in figure.axes:
            histories, fits = self.curves(axes)
            self.assertEqual(len(fits), 3)
            for history, fit in zip(histories, fits):
                # The order of operations differs; phases up to 100 rad have a rounding of 1e-13.
                np.testing.assert_allclose(
                    fit.get_ydata(), history.get_ydata(), rtol=0.0, atol=1e-12
                )

    def test_a_missing_point_is_replaced_by_the_nearest(self):
        # Without (β = 150, Y = 5 GPa), β = 100 and 200 are equally near, and the first is taken.
        figure = figures.tip_history_figure(self.open(failed_point=7, missing_point=None))
        histories, _ = self.curves(figure.axes[0])
        tip = self.truth.tip(4)
        np.testing.assert_array_equal(histories[1].get_ydata(), tip / tip[0])
        self.assertEqual(labels_of(figure.axes[0])[1], "$Y$ = 5 GPa, β = 100")

    def test_a_design_of_other_dampings_shows_its_smallest_middle_and_largest(self):
        study = self.open(dampings=(5.0, 10.0, 15.0), failed_point=None, missing_point=None)
        figure = figures.tip_history_figure(study)
        self.assertEqual(labels_of(figure.axes[1])[:3], ["β = 5", "β = 10", "β = 15"])
        self.assertEqual(figure.axes[1].get_title(), "$Y$ = 10 GPa")

    def test_one_point_gives_one_curve(self):
        study = self.open(
            dampings=(150.0,), moduli_gpa=(4.0,), failed_point=None, missing_point=None
        )
        figure = figures.tip_history_figure(study)
        self.assertEqual([len(axes.lines) for axes in figure.axes], [3, 3])

    def test_it_is_skipped_without_histories(self):
        with self.assertRaisesRegex(FigureSkipped, 'stores no tip histories .store = "fit"'):
            figures.tip_history_figure(self.open(store="fit"))


class Design(FigureTest):
    def test_cells_hold_the_two_ratios_and_mask_points_without_an_answer(self):
        figure = figures.design_figure(self.open())
        ratio = self.truth.frequency / np.sqrt(self.truth.modulus_gpa)
        done = self.truth.is_completed
        # β = 25 is the lowest tenth of the ten completed points; points 0, 1, 2.
        deviation = 100.0 * (ratio / np.median(ratio[:3]) - 1.0)
        decay = -1e3 * self.truth.decay_per_cycle / self.truth.damping
        for axes, expected in zip(figure.axes, (deviation, decay)):
            (mesh,) = [c for c in axes.collections if isinstance(c, QuadMesh)]
            cells = mesh.get_array()
            np.testing.assert_array_equal(np.ma.getmaskarray(cells).ravel(), ~done)
            # The deviation is a small difference of ratios near 1: 1e-14 in per cent of them.
            np.testing.assert_allclose(cells.compressed(), expected[done], rtol=1e-12, atol=1e-12)
        mesh_edges = mesh.get_coordinates()
        self.assertEqual(mesh_edges.shape, (5, 4, 2))
        np.testing.assert_allclose(mesh_edges[0, :, 0], [0.0, 3.0, 7.5, 12.5], rtol=1e-15)
        np.testing.assert_allclose(mesh_edges[:, 0, 1], [0.0, 62.5, 125, 175, 225], rtol=1e-15)

    def test_a_scattered_design_is_drawn_as_points(self):
        study = self.open()
        scatter = np.linspace(0.0, 1.0, 12)
        self.truth.damping += scatter
        self.truth.modulus_gpa += scatter
        study.close()
        with Study(self.truth.write(self.folder)) as scattered:
            figure = figures.design_figure(scattered)
        (points,) = figure.axes[0].collections
        self.assertIsInstance(points, PathCollection)
        self.assertEqual(points.get_offsets().shape, (10, 2))

    def test_it_is_skipped_where_it_would_mean_nothing(self):
        cases = (
            ({"moduli_gpa": (4.0,), "failed_point": None, "missing_point": None}, "does not vary"),
            ({"dampings": (0.0, 50.0), "missing_point": None}, "undamped bonds"),
            ({"extra_factors": {"length_mm": ("mm", np.arange(12.0))}}, "more than .*length_mm"),
        )
        for options, reason in cases:
            with self.subTest(reason), self.assertRaisesRegex(FigureSkipped, reason):
                study = self.open(**options)
                try:
                    figures.design_figure(study)
                finally:
                    study.close()  # the next case writes the same file


class Command(FigureTest):
    def run_command(self, *arguments):
        """Exit code, standard output, standard error."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = figures.main([str(argument) for argument in arguments])
            except SystemExit as stop:
                code = stop.code
        return code, out.getvalue(), err.getvalue()

    def assert_refused(self, pattern, *arguments):
        code, out, err = self.run_command(*arguments)
        self.assertEqual((code, out), (2, ""))
        self.assertRegex(err, pattern)
        self.assertEqual(err.count("\n"), 1)

    def test_every_figure_is_written_in_every_format_and_its_path_printed(self):
        self.open()
        target = self.folder / "figures" / "new"
        code, out, err = self.run_command(self.folder, "-o", target, "--format", "png,pdf,svg")
        self.assertEqual((code, err), (0, ""))
        names = ("regression", "residuals", "tip_history", "design")
        expected = [target / f"{n}.{f}" for n in names for f in ("png", "pdf", "svg")]
        self.assertEqual(out.split(), [str(path) for path in expected])
        starts = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}
        for path in expected:
            self.assertTrue(path.read_bytes().startswith(starts[path.suffix]), path)

    def test_the_same_data_give_the_same_bytes(self):
        self.open()
        written = []
        for name in ("one", "two"):
            self.run_command(self.folder, "-o", self.folder / name, "--format", "png,pdf,svg")
            paths = sorted((self.folder / name).iterdir())
            written.append([path.read_bytes() for path in paths])
        self.assertEqual(len(written[0]), 12)
        self.assertEqual(written[0], written[1])

    def test_figures_go_to_the_study_by_default_and_skipped_ones_are_named(self):
        self.open(store="fit")
        code, out, err = self.run_command(self.folder)
        self.assertEqual(code, 0)
        self.assertTrue((self.folder / "regression.png").is_file())
        self.assertFalse((self.folder / "tip_history.png").exists())
        self.assertIn("tip_history is left out: the study stores no tip histories", err)

    def test_everything_that_a_folder_holds_is_drawn(self):
        self.open()
        synthetic_results.write_calibration(self.folder, ("S1",))
        synthetic_results.write_comparison(self.folder)
        synthetic_results.write(self.folder, "diagnosis.json", synthetic_results.diagnosis())
        code, out, err = self.run_command(self.folder, "-o", self.folder / "all")
        self.assertEqual(code, 0)
        names = {Path(line).stem for line in out.split()}
        self.assertLessEqual({"regression", "design", "residuals", "calibration_motion-001",
                              "comparison_residuals", "comparison_ladder",
                              "diagnosis_error_ladder", "diagnosis_explanations"}, names)
        self.assertIn("calibration_motion-002 is left out: broken was not calibrated: no motion", err)

    def test_bad_input_ends_with_2_and_one_sentence(self):
        self.assert_refused("study.h5 does not exist", self.folder)
        self.assert_refused("is not a folder", self.folder / "nowhere")
        self.open()
        self.assert_refused("'jpg' is not one of png, pdf, svg", self.folder, "--format", "jpg")
        self.assert_refused("required: DIR")
        (self.folder / "a_file").write_text("")
        self.assert_refused("a_file", self.folder, "-o", self.folder / "a_file")
        (self.folder / "summary.json").write_text(json.dumps({"points": 12}))
        self.assert_refused("lacks 'regression'", self.folder)
        (self.folder / "summary.json").unlink()
        self.assert_refused("summary.json does not exist", self.folder)

    def test_a_study_without_a_single_answer_is_refused(self):
        self.open(dampings=(25.0,), moduli_gpa=(1.0, 2.0), failed_point=0, missing_point=1)
        self.assert_refused("no point was completed with a fit", self.folder)


if __name__ == "__main__":
    unittest.main()
