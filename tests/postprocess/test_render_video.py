# SPDX-License-Identifier: BSD-3-Clause
"""Rendered videos show the stem at its position in the archive."""
import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import numpy as np
import render_video
from synthetic_study import Synthetic

STEM = {"stem.bond_length_mm": 50.0, "stem.sphere_diameter_mm": 3.0, "stem.bond_diameter_mm": 3.0}


class RenderVideo(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)

    def render(self, *options, **study):
        self.truth = Synthetic(extra_settings=STEM, **study)
        self.truth.write(self.folder)
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = render_video.main([str(self.folder), "-o", str(self.folder / "video"), *options])
        return code, out.getvalue().strip(), err.getvalue()

    def picture(self, number: int) -> np.ndarray:
        content = (self.folder / f"video/frames/{number:05d}.pgm").read_bytes()
        head, _, pixels = content.partition(b" 255\n")
        columns, rows = map(int, head.split()[1:])
        return np.frombuffer(pixels, np.uint8).reshape(rows, columns).astype(float)

    def test_puts_the_tip_where_it_is_in_every_frame(self):
        code, settings, err = self.render("--point", "5", "--mm-per-px", "0.5")
        self.assertEqual((code, err), (0, ""))
        text = Path(settings).read_text("utf-8")
        self.assertIn("length_mm = 150", text)
        axis = int(text.split("axis_column = ")[1].split()[0])
        clamp = int(text.split("clamp_row = ")[1].split()[0])
        for number in (0, 7, 9, 20):
            time = max(0.0, (number - render_video.RELEASE_FRAME) / 960.0)
            deflection = 1e3 * np.interp(time, self.truth.time, self.truth.tip(5))
            # 3 px below the tip: the last bond leans, so the axis there is 3/100 of the way back.
            row = self.picture(number)[clamp - 297]
            light = np.clip(row - 1.4 * render_video.BACKGROUND, 0.0, None)
            found = 0.5 * ((light * np.arange(row.size)).sum() / light.sum() - axis)
            self.assertAlmostEqual(found, 0.97 * deflection, delta=0.15)  # a third of a pixel

    def test_holds_the_stem_before_the_release(self):
        self.render("--point", "5")
        held = np.mean([self.picture(number) for number in range(render_video.HELD_FRAMES)], axis=0)
        # Pictures differ only by noise of 3 grey values; the mean of eight pictures is taken.
        self.assertLess(np.abs(held - self.picture(0)).mean(), 4.0)

    def test_is_the_same_twice(self):
        self.render()
        first = self.picture(3)
        self.render()
        np.testing.assert_array_equal(first, self.picture(3))

    def test_renders_a_table_of_axis_positions(self):
        (self.folder / "stem.toml").write_text(
            "[stem]\nlength_mm = 100\ndiameter_mm = 3\ndensity_kg_m3 = 125\n", "utf-8")
        rows = ["time_s,height_0_mm,deflection_0_mm,height_1_mm,deflection_1_mm",
                "0,0,0,100,10", "0.002,0,0,100,-10", "0.004,0,0,100,0"]
        (self.folder / "axis.csv").write_text("\n".join(rows) + "\n", "utf-8")
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            code = render_video.main([str(self.folder), "-o", str(self.folder / "video")])
        self.assertEqual(code, 0)
        text = Path(out.getvalue().strip()).read_text("utf-8")
        self.assertIn("fps = 500\n", text)
        self.assertNotIn("added_mass", text)
        axis = int(text.split("axis_column = ")[1].split()[0])
        clamp = int(text.split("clamp_row = ")[1].split()[0])
        for number, middle in enumerate((5.0, -5.0, 0.0)):
            row = self.picture(number)[clamp - 100]  # at half of the height
            light = np.clip(row - 1.4 * render_video.BACKGROUND, 0.0, None)
            found = 0.5 * ((light * np.arange(row.size)).sum() / light.sum() - axis)
            self.assertAlmostEqual(found, middle, delta=0.15)

    def test_refuses_a_study_without_positions(self):
        code, out, err = self.render(store="tip")
        self.assertEqual((code, out), (2, ""))
        self.assertIn("does not store positions", err)


if __name__ == "__main__":
    unittest.main()
