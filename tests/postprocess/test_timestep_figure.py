# SPDX-License-Identifier: BSD-3-Clause
"""The figure of a time-step study shows the study's numbers."""
import contextlib
import io
import tempfile
import unittest
from dataclasses import dataclass
from pathlib import Path

import figures
import numpy as np
from culm.archive import Study, StudyError
from synthetic_study import Synthetic, write_summary
from timestep_figure import timestep_figure
from timestep_results import extrapolated_to_zero

FRACTIONS = ("0.25", "0.5", "0.75", "0.9")
A, B = 1.0, 2.83
SLOPE = 3e-8  # relative error of b2 at the limit; b1's is twice that


@dataclass
class SyntheticSteps(Synthetic):
    """Limits of the damped oscillator; the errors of b1 and b2 are linear in the step."""

    store: str = "fit"
    with_steps: bool = True

    def __post_init__(self):
        super().__post_init__()
        self.extra_settings = {"study.kind": "timestep"}
        self.bond_time = 1e-6 / np.sqrt(self.modulus_gpa)
        b = B * self.damping
        self.limit = 2.0 * self.bond_time / (b + np.sqrt(b * b + 4.0 * A))

    def columns(self):
        table = {
            "limit_stable": ("s", 0.999 * self.limit),
            "limit_unstable": ("s", 1.001 * self.limit),
            "limit_trials": ("1", np.full(self.points, 24.0)),
            "limit_transverse": ("s", 1.2 * self.limit),
            "limit_axial": ("s", self.limit),
            "limit_rule": ("s", 0.9 * self.limit),
            "bond_time": ("s", self.bond_time),
        }
        for name in FRACTIONS if self.with_steps else ():
            share = float(name)
            at = {
                "timestep": ("s", share * self.limit),
                "outcome": ("1", np.zeros(self.points)),
                "decay_per_cycle": ("1", self.decay_per_cycle * (1.0 + 2.0 * SLOPE * share)),
                "frequency": ("Hz", self.frequency * (1.0 + SLOPE * share)),
            }
            table |= {f"{quantity}_at_{name}": column for quantity, column in at.items()}
        blank = np.where(self.is_completed, 0.0, np.nan)
        return {name: (unit, values + blank) for name, (unit, values) in table.items()}

    def summary(self):
        coefficients = [{"term": "A", "coefficient": A}, {"term": "B", "coefficient": B}]
        return {"kind": "timestep", "regression": {"damped_oscillator": {"coefficients": coefficients}}}


class TimestepFigure(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def open(self, **options):
        self.truth = SyntheticSteps(**options)
        study = Study(self.truth.write(self.folder))
        self.addCleanup(study.close)
        return study

    def test_limits_are_relative_to_the_bond_time_of_each_stem(self):
        axes = timestep_figure(self.open()).axes[0]
        bisected, linearised, rule = axes.lines
        done = self.truth.is_completed
        np.testing.assert_array_equal(bisected.get_xdata(), self.truth.damping[done])
        expected = (self.truth.limit / self.truth.bond_time)[done]
        # The limit allows for the rounding of the bracket's middle.
        np.testing.assert_allclose(bisected.get_ydata(), expected, rtol=1e-14)
        np.testing.assert_allclose(np.sort(linearised.get_ydata()), np.sort(expected), rtol=1e-14)
        np.testing.assert_allclose(
            np.sort(rule.get_ydata()), np.sort(0.9 * expected), rtol=1e-14
        )
        self.assertIn("= 1 + 2.83", axes.texts[0].get_text())

    def test_ratios_are_those_to_the_bisected_limit(self):
        rule, linearised, one = timestep_figure(self.open()).axes[1].lines
        np.testing.assert_allclose(rule.get_ydata(), 0.9, rtol=1e-14)
        np.testing.assert_allclose(linearised.get_ydata(), 1.0, rtol=1e-14)
        self.assertEqual(list(one.get_ydata()), [1.0, 1.0])

    def test_errors_are_those_against_step_zero(self):
        figure = timestep_figure(self.open())
        shares = np.array([float(name) for name in FRACTIONS])
        for axes, factor in ((figure.axes[2], 2.0), (figure.axes[3], 1.0)):
            measured = axes.lines
            self.assertEqual(len(measured), self.truth.is_completed.sum())
            for line in measured:
                np.testing.assert_allclose(line.get_xdata(), shares, rtol=1e-14)
                # Numbers near 1 have a rounding of 2e-16, the errors are 1e-8 and more.
                np.testing.assert_allclose(line.get_ydata(), factor * SLOPE * shares, rtol=1e-6)

    def test_shows_the_limits_alone_without_compared_steps(self):
        self.assertEqual(len(timestep_figure(self.open(with_steps=False)).axes), 2)

    def test_shows_no_law_if_there_is_none(self):
        study = self.open()
        write_summary(self.folder, {"regression": {"damped_oscillator": {"reason": "one stem"}}})
        self.assertEqual(len(timestep_figure(study).axes[0].texts), 0)
        write_summary(self.folder, {"regression": {}})
        with self.assertRaises(StudyError):
            timestep_figure(study)

    def test_undamped_stems_are_at_the_left_end(self):
        axes = timestep_figure(self.open(dampings=(0.0, 1.0, 4.0), failed_point=None,
                                         missing_point=None)).axes[0]
        self.assertEqual(sorted(set(axes.lines[0].get_xdata())), [0.5, 1.0, 4.0])
        self.assertTrue(axes.get_xlabel().endswith("left end: 0"))

    def test_extrapolation_is_exact_for_parabolas_and_needs_two_steps(self):
        steps = np.array([[0.4, 0.1, 0.3, 0.2], [0.1, 0.2, 0.3, 0.4]])
        values = 3.0 + 2.0 * steps - 5.0 * steps**2
        values[0, 0] = 77.0  # the largest of four steps is not used
        values[1, 1:] = np.nan
        found = extrapolated_to_zero(steps, values)
        self.assertAlmostEqual(found[0], 3.0, delta=1e-14)
        self.assertTrue(np.isnan(found[1]))

    def test_is_the_one_that_the_command_draws(self):
        self.open()
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            self.assertEqual(figures.main([str(self.folder)]), 0)
        self.assertEqual(printed.getvalue(), f"{self.folder / 'timestep.png'}\n")
        self.assertTrue((self.folder / "timestep.png").is_file())


if __name__ == "__main__":
    unittest.main()
