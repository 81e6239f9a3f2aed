# SPDX-License-Identifier: BSD-3-Clause
"""culm track: from frames to a measurement folder, on one and on two ranks."""

import json
import math
import random
import shutil
import subprocess
import unittest

from culm_program import BAD_INPUT, DONE, PATIENCE, POINTS_FAILED, PROGRAM, CulmTest, launcher

LAUNCH = launcher(2)
WIDTH, HEIGHT, CLAMP_ROW, LENGTH, STEM_WIDTH, FRAMES = 70, 90, 84, 76, 4.0, 90


def frame(number: int) -> bytes:
    """A portable grey map of a bright stem that is held for 9 frames and then swings."""
    generator = random.Random(number)
    cycles = max(0.0, (number - 8.5) / 12)
    swing = math.exp(-0.7 * cycles) * math.cos(2 * math.pi * cycles) if cycles else 1.0
    pixels = bytearray()
    for row in range(HEIGHT):
        height = CLAMP_ROW - row
        s = height / LENGTH
        axis = 35 + 14 * swing * 0.5 * s * s * (3 - s)
        for column in range(WIDTH):
            grey = 60.0
            if 0 < height <= LENGTH:
                distance = abs(column - axis) - STEM_WIDTH / 2
                grey += 130 / (1 + math.exp(min(50.0, 3 * distance)))
            pixels.append(round(grey + generator.gauss(0, 2)))
    return b"P5 %d %d 255\n" % (WIDTH, HEIGHT) + bytes(pixels)


PICTURES = [frame(number) for number in range(FRAMES)]

VIDEO = """
[video]
frames = "{frames}/%03d.pgm"
fps = 960
mm_per_px = 1.0
[stem]
id = "{name}"
length_mm = 76
diameter_mm = 4
density_kg_m3 = 125
"""


class TrackTest(CulmTest):
    def setUp(self):
        super().setUp()
        (self.folder / "frames").mkdir()
        for number, picture in enumerate(PICTURES):
            (self.folder / f"frames/{number:03d}.pgm").write_bytes(picture)
        for name in ("A", "B"):
            self.write(f"{name}.toml", VIDEO.format(frames="frames", name=name))
        self.write("empty.toml", VIDEO.format(frames="nothing", name="E"))

    def content(self, folder: str) -> str:
        return (self.folder / folder / "deflection.csv").read_text(encoding="utf-8")


class Track(TrackTest):
    def test_writes_the_measurement_and_how_it_came_about(self):
        finished = self.culm("track", "A.toml", "-o", "out/a")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stdout, r"(?m)^A: 90 frames at 960 frames/s")
        self.assertRegex(finished.stdout, r"(?m)^    release  frame 8\.\d+, pulled to the right")
        self.assertRegex(finished.stdout, r"(?m)^    swing    \d\d\.\d\d Hz, 1[12]\.\d frames per cycle; "
                                          r"as a plain beam, E = \d")
        out = self.folder / "out/a"
        self.assertEqual(sorted(path.name for path in out.iterdir()),
                         ["contact_sheet.png", "deflection.csv", "stem.toml",
                          "track.json", "uncertainty.csv"])
        self.assertTrue((out / "contact_sheet.png").read_bytes().startswith(b"\x89PNG"))
        self.assertIn('noise_source = "9 frames before the release"',
                      (out / "stem.toml").read_text(encoding="utf-8"))
        facts = json.loads((out / "track.json").read_text(encoding="utf-8"))
        self.assertEqual(facts["view"]["stem"], "bright")
        self.assertEqual(facts["release"]["last_held_frame"], 8)
        self.assertAlmostEqual(facts["swing_hz"], 80.0, delta=1.0)
        self.assertEqual(self.culm("fit", "out/a").returncode, DONE)

    def test_gives_the_same_for_any_number_of_threads(self):
        for threads in ("1", "3"):
            self.assert_exit(self.culm("track", "A.toml", "-o", threads, "--threads", threads),
                             DONE)
        self.assertEqual(self.content("1"), self.content("3"))

    def test_refuses_what_it_cannot_track(self):
        self.assert_refused(self.culm("track", "empty.toml", "-o", "out"),
                            "culm: nothing: cannot be read: No such file or directory\n")
        self.assertFalse((self.folder / "out").exists())

    def test_continues_with_the_other_videos(self):
        finished = self.culm("track", "A.toml", "empty.toml", "-o", "out")
        self.assert_exit(finished, POINTS_FAILED)
        self.assertIn("culm: 1 of 2 videos gave a measurement\n", finished.stderr)
        self.assertTrue((self.folder / "out/A/deflection.csv").exists())
        self.assertFalse((self.folder / "out/E").exists())

    def test_refuses_two_videos_of_one_stem(self):
        self.assert_refused(
            self.culm("track", "A.toml", "A.toml", "-o", "out"),
            'culm: A.toml: stem.id = "A" is that of A.toml too; each stem gets a folder of its '
            "name\n")

    def test_says_once_that_a_folder_cannot_be_written(self):
        self.write("out", "a file")
        finished = self.culm("track", "A.toml", "-o", "out")
        self.assert_exit(finished, BAD_INPUT)
        self.assertEqual(finished.stderr.count("culm: "), 1)


class HandOver(TrackTest):
    def test_finds_its_partner_through_a_link(self):
        (self.folder / "linked").symlink_to(PROGRAM)
        finished = subprocess.run(["./linked", "track", "A.toml", "-o", "out"], check=False,
                                  cwd=self.folder, capture_output=True, text=True,
                                  timeout=PATIENCE)
        self.assertEqual(finished.returncode, DONE, finished.stderr)

    def test_says_what_is_missing_without_its_partner(self):
        shutil.copy(PROGRAM, self.folder / "alone")
        finished = subprocess.run(["./alone", "track", "A.toml", "-o", "out"], check=False,
                                  cwd=self.folder, capture_output=True, text=True,
                                  timeout=PATIENCE)
        self.assertEqual(finished.returncode, BAD_INPUT)
        self.assertIn("culm-track: cannot be run; install it next to culm", finished.stderr)

    @unittest.skipIf(shutil.which("ldd") is None, "no ldd here")
    def test_spares_other_commands_the_video_libraries(self):
        libraries = subprocess.run(["ldd", PROGRAM], check=True, capture_output=True, text=True,
                                   timeout=PATIENCE).stdout
        self.assertIn("libhdf5", libraries)
        self.assertNotIn("opencv", libraries)


class TwoRanks(TrackTest):
    def test_share_the_videos_and_give_the_same(self):
        process = self.start(*LAUNCH, PROGRAM, "track", "A.toml", "B.toml", "-o", "two")
        output, errors = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, DONE, errors)
        self.assertLess(output.index("A: 90 frames"), output.index("B: 90 frames"))
        self.assert_exit(self.culm("track", "A.toml", "B.toml", "-o", "one"), DONE)
        for name in ("A", "B"):
            self.assertEqual(self.content(f"two/{name}"), self.content(f"one/{name}"))


if __name__ == "__main__":
    unittest.main()
