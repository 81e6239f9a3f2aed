# SPDX-License-Identifier: BSD-3-Clause
"""The figures of culm diagnose show the numbers of diagnosis.json; checked on their objects."""
import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import diagnose_figures
from command_results import Diagnosis, DiagnosisError
from figure_style import FigureSkipped


def spot(effect, value, modulus, damping):
    return {"effect": effect, "beyond_bounds": value is None,
            "smallest_visible": {"parameter": "size", "value": value, "unit": "kg"},
            "bias": {"bond_youngs_modulus": modulus, "bond_damping": damping}}


def force(kind, key):
    return {"kind": kind, "form": "(-0.5)*v*abs(v)",
            "against_displacement": [{"displacement_mm": x, "velocity_m_s": 0.0, key: 0.0}
                                     for x in (-1.0, 1.0)],
            "against_velocity": [{"displacement_mm": 0.0, "velocity_m_s": v, key: -0.5 * v * abs(v)}
                                 for v in (-2.0, 0.0, 2.0)]}


class DiagnoseFigures(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        self.content = {
            "format": "culm-diagnosis", "version": 2, "measurement": "T2", "verdict": "effect",
            "effects": ["quadratic_drag"], "noise_mm": 0.04,
            "ladder": [{"model": ["baseline"], "rmse_mm": 0.2},
                       {"model": ["baseline", "quadratic_drag"], "rmse_mm": 0.0403}],
            "explanations": [{"effects": ["quadratic_drag"], "probability": 0.9},
                             {"effects": [], "probability": 0.1}],
            "blind_spots": [spot("tip_mass", 2e-6, -0.07, 0.0), spot("taper", 0.01, 0.02, 0.01),
                            spot("camera_tilt", None, 0.0, 0.0),
                            {"effect": "gravity", "failure": "no"}],
            "missing_force": None,
            "alternatives": [{"probability": 1.0, "families": [
                {"family": "air", "members": ["quadratic_drag"], "by_family": True}]}],
        }
        self.write()

    def write(self):
        (self.folder / "diagnosis.json").write_text(json.dumps(self.content), "utf-8")

    def figure(self, name):
        return diagnose_figures.FIGURES[name](Diagnosis(self.folder))

    def test_heading_names_what_the_verdict_names(self):
        self.assertEqual(Diagnosis(self.folder).heading,
                         "T2: effect, air (most like quadratic_drag)")
        self.content["alternatives"][0]["families"] += [
            {"family": "clamp", "members": ["clamp_compliance"], "by_family": False},
            {"family": "stem geometry", "members": ["taper", "local_defect"], "by_family": False}]
        self.write()
        self.assertEqual(Diagnosis(self.folder).heading,
                         "T2: effect, air (most like quadratic_drag) and clamp_compliance and "
                         "stem geometry (taper or local_defect)")

    def test_ladder_falls_to_the_noise(self):
        axes = self.figure("error_ladder").axes[0]
        self.assertEqual(list(axes.lines[0].get_xdata()), [0.2, 0.0403])
        self.assertEqual(axes.lines[1].get_xdata()[0], 0.04)
        self.assertEqual([label.get_text() for label in axes.get_yticklabels()],
                         ["baseline", "baseline +\nquadratic_drag"])

    def test_explanations_show_their_probability_likeliest_on_top(self):
        axes = self.figure("explanations").axes[0]
        self.assertEqual([bar.get_width() for bar in axes.containers[0]], [0.9, 0.1])
        self.assertEqual([label.get_text() for label in axes.get_yticklabels()],
                         ["quadratic_drag", "published chain"])

    def test_blind_spots_show_what_is_visible_at_some_size_the_worst_on_top(self):
        modulus, damping = self.figure("blind_spots").axes
        self.assertEqual([label.get_text() for label in modulus.get_yticklabels()],
                         ["taper 0.01 kg", "tip_mass 2·10⁻⁶ kg"])
        for bar, expected in zip(modulus.containers[0], [2.0, -7.0]):
            self.assertAlmostEqual(bar.get_width(), expected)
        for bar, expected in zip(damping.containers[0], [1.0, 0.0]):
            self.assertAlmostEqual(bar.get_width(), expected)

    def test_missing_force_is_drawn_against_displacement_and_velocity(self):
        with self.assertRaises(FigureSkipped):
            self.figure("missing_force")
        self.content["missing_force"] = force("force_per_length", "force_n_per_m")
        self.write()
        displacement, velocity = self.figure("missing_force").axes
        self.assertEqual(list(displacement.lines[0].get_xdata()), [-1.0, 1.0])
        self.assertEqual(list(velocity.lines[0].get_ydata()), [2.0, 0.0, -2.0])
        self.assertEqual(displacement.get_ylabel(), "force per length, N/m")

    def test_missing_moment_has_its_own_unit(self):
        self.content["missing_force"] = force("bending_moment", "moment_n_m")
        self.write()
        self.assertEqual(self.figure("missing_force").axes[0].get_ylabel(), "bending moment, N m")

    def test_are_written_by_one_command(self):
        self.content["missing_force"] = force("force_per_length", "force_n_per_m")
        self.write()
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            self.assertEqual(diagnose_figures.main([str(self.folder)]), 0)
        names = [Path(line).name for line in printed.getvalue().splitlines()]
        self.assertEqual(names, ["error_ladder.png", "explanations.png", "blind_spots.png",
                                 "missing_force.png"])
        for line in printed.getvalue().splitlines():
            self.assertGreater(Path(line).stat().st_size, 1000)

    def test_refuse_another_file_in_one_sentence(self):
        (self.folder / "diagnosis.json").write_text("[]", "utf-8")
        with self.assertRaisesRegex(DiagnosisError, "not written by this version"):
            Diagnosis(self.folder)
        with contextlib.redirect_stderr(io.StringIO()) as complaint:
            self.assertEqual(diagnose_figures.main([str(self.folder / "nothing")]), 2)
        self.assertEqual(complaint.getvalue().count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
