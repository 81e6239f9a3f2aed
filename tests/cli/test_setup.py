# SPDX-License-Identifier: BSD-3-Clause
"""culm setup: the detection, the page it writes, and the dialogue in the terminal."""

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
import tomllib
import unittest
from importlib.util import find_spec
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PATIENCE, PROGRAM, CulmTest

sys.path.append(str(Path(__file__).resolve().parents[1] / "support"))
HAS_NUMPY = find_spec("numpy") is not None
ANSWERS = {"id": "", "length_mm": "160", "diameter_mm": "2.8", "density_kg_m3": "125",
           "fps": "960", "mm_per_px": "", "up": "", "clamp": ""}


def page_data(page: Path) -> dict:
    """The JSON in a page."""
    text = page.read_text("utf-8")
    begin = text.index('id="setup">') + len('id="setup">')
    return json.loads(text[begin:text.index("</script>", begin)])


@unittest.skipUnless(HAS_NUMPY, "numpy is missing")
class Setup(CulmTest):
    @classmethod
    def setUpClass(cls):
        import tempfile
        from drawn_video import write_frames
        place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(place.cleanup)
        cls.frames = Path(place.name) / "frames"
        write_frames(cls.frames)

    def draw_grey_frames(self):
        """Twenty small pictures without a stem."""
        (self.folder / "grey").mkdir()
        for number in range(20):
            (self.folder / f"grey/{number:03}.pgm").write_bytes(b"P5 64 48 255\n" + 48 * 64 * b"Z")

    def dialogue(self, output: str, **answers):
        text = "".join(f"{answer}\n" for answer in (ANSWERS | answers).values())
        return subprocess.run([PROGRAM, "setup", self.frames, "-o", output, "--text"], input=text,
                              cwd=self.folder, text=True, capture_output=True, timeout=PATIENCE,
                              check=False)

    def test_leaves_a_whole_page_or_none_when_killed_or_out_of_space(self):
        self.draw_grey_frames()
        started = time.monotonic()
        self.assert_exit(self.culm("setup", "grey", "-o", "S07"), DONE)
        duration = time.monotonic() - started
        page = self.folder / "S07/setup.html"
        whole = page.read_text("utf-8")
        page.unlink()
        chance = random.Random(1)
        for _ in range(10):
            process = subprocess.Popen([PROGRAM, "setup", "grey", "-o", "S07"],
                                       cwd=self.folder, start_new_session=True,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(chance.uniform(0.5, 1.1) * duration)
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            if page.exists():
                self.assertTrue(page.read_text("utf-8") == whole)
        self.assert_exit(self.culm("setup", "grey", "-o", "S07"), DONE)
        full = self.culm("setup", "grey", "-o", "S07", preexec_fn=lambda: resource.setrlimit(
            resource.RLIMIT_FSIZE, (10_000, 10_000)))
        self.assert_exit(full, BAD_INPUT)
        self.assertIn("File too large", full.stderr)
        self.assertTrue(page.read_text("utf-8") == whole, "the page of the run before is changed")
        self.assertEqual([file.name for file in page.parent.glob("*.tmp")], [])

    def test_finds_the_stem_the_release_and_the_swing(self):
        import drawn_video as truth
        self.assert_exit(self.culm("setup", self.frames, "-o", "S07"), DONE)
        data = page_data(self.folder / "S07/setup.html")
        found = data["detected"]
        self.assertEqual((found["up"], found["stem"], found["pull_side"]),
                         ("decreasing_column", "dark", "bottom"))
        self.assertAlmostEqual(found["clamp"][0], truth.CLAMP_COLUMN, delta=1.5)
        self.assertAlmostEqual(found["clamp"][1], truth.AXIS_ROW, delta=1.0)
        self.assertAlmostEqual(found["tip"][0], truth.TIP_COLUMN, delta=1.5)
        self.assertAlmostEqual(found["width_px"], truth.THICKNESS, delta=1.0)
        self.assertEqual(found["release_frame"], truth.HELD - 1)
        self.assertAlmostEqual(found["cycles_per_frame"], truth.FREQUENCY / truth.FPS, delta=5e-4)
        self.assertEqual(data["frames_key"], "frames/frame_%04d.pgm")
        self.assertEqual((data["stated_fps"], data["proposed_fps"]), (None, None))
        self.assertEqual((data["frame_count"], data["bands"]), (truth.FRAMES, 1))
        numbers = [frame["number"] for frame in data["frames"]]
        self.assertEqual(numbers, sorted(set(numbers)))
        self.assertTrue({truth.HELD - 1, truth.HELD} <= set(numbers))

    def test_asks_in_the_terminal_and_writes_what_track_reads(self):
        import drawn_video as truth
        # Answers that video.toml does not allow are asked for again.
        finished = self.dialogue("S07", length_mm="-1\n160", up="decreasing_colum\n")
        self.assert_exit(finished, DONE)
        self.assertIn("must be a number in [1, 100000]", finished.stdout)
        self.assertIn("rate     not stated in the recording", finished.stdout)
        self.assertRegex(finished.stdout, r"assumed: the tip is toward decreasing_column .*up")
        self.assertIn("0.513 g/m, 82.1 mg on 160 mm", finished.stdout)
        self.assertIn("(did you mean decreasing_column?)", finished.stdout)
        written = tomllib.loads((self.folder / "S07/video.toml").read_text("utf-8"))
        self.assertEqual(written["stem"], {"id": "S07", "length_mm": 160.0, "diameter_mm": 2.8,
                                           "density_kg_m3": 125.0})
        self.assertAlmostEqual(written["video"]["mm_per_px"], truth.MM_PER_PX, delta=2e-3)
        self.assertIn("next: culm track S07/video.toml -o S07/measurement\n", finished.stdout)
        self.assert_exit(self.culm("track", "S07/video.toml", "-o", "S07/measurement", "-q"), DONE)
        fit = self.culm("fit", "S07/measurement", "--phase", "free", "--json", "-")
        frequency = json.loads(fit.stdout)["stems"][0]["b2_hz"]["value"]
        self.assertAlmostEqual(frequency / truth.FREQUENCY, 1.0, delta=2e-3)

    def test_takes_the_mass_as_a_person_knows_it(self):
        for answer, line in (("82.1 mg", "mass_mg = 82.1"), ("0.513 g/m", "linear_density_kg_m"),
                             ("83.3 material", "material_density_kg_m3 = 83.3")):
            folder = line.split("_", maxsplit=1)[0]
            finished = self.dialogue(folder, density_kg_m3=f"1 t\n{answer}")
            self.assert_exit(finished, DONE)
            self.assertIn("must be a number, alone or with mg, g/m or material", finished.stdout)
            self.assertIn(line, (self.folder / folder / "video.toml").read_text("utf-8"))

    def test_leads_to_no_folder_if_the_scale_is_wrong(self):
        self.assert_exit(self.dialogue("S07", mm_per_px="0.6"), DONE)
        refused = self.culm("track", "S07/video.toml", "-o", "measured", "-q")
        self.assert_exit(refused, BAD_INPUT)
        self.assertIn("with mm_per_px = 0.6 the stem is seen up to ", refused.stderr)
        self.assertFalse((self.folder / "measured").exists())

    def test_writes_nothing_if_the_answers_end(self):
        finished = self.dialogue("S07", fps="")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("culm: the answers end at ", finished.stderr)
        self.assertFalse((self.folder / "S07/video.toml").exists())

    def test_refuses_to_replace_a_description_or_other_pictures(self):
        (self.folder / "S07").mkdir()
        self.write("S07/video.toml", "")
        finished = self.culm("setup", self.frames, "-o", "S07")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("S07/video.toml is there already", finished.stderr)
        (self.folder / "S08/frames").mkdir(parents=True)
        finished = self.culm("setup", self.frames, "-o", "S08")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("S08/frames is there already and is not ", finished.stderr)

    def test_refuses_what_is_no_recording(self):
        (self.folder / "empty").mkdir()
        for named, reason in (("none.mp4", "there is no such file or folder"),
                              ("empty", "the folder has no numbered pictures")):
            finished = self.culm("setup", named, "-o", "out")
            self.assert_exit(finished, BAD_INPUT)
            self.assertIn(f"culm: {named}: {reason}", finished.stderr)
            self.assertFalse((self.folder / "out").exists())

    def test_shows_frames_without_a_stem_with_the_reason(self):
        self.draw_grey_frames()
        self.assert_exit(self.culm("setup", "grey", "-o", "out"), DONE)
        data = page_data(self.folder / "out/setup.html")
        self.assertIsNone(data["detected"])
        self.assertIn("The stem was not found: ", data["remark"])
        self.assertEqual(len(data["frames"]), 16)


if __name__ == "__main__":
    unittest.main()
