# SPDX-License-Identifier: BSD-3-Clause
"""A mapping and a recording become a measurement; mistakes are refused with their line."""
import csv
import math
import os
import random
import tomllib
import unittest
from pathlib import Path

import import_recording
from recording_files import RecordingFiles

TRACK = os.environ.get("CULM_TRACK")
STEM = """[stem]
id = "beam"
length_mm = 100
density_kg_m3 = 1070
[section]
shape = "rectangle"
width_mm = 30
height_mm = 30
[release]
kind = "held_straight"
[measurement]
reading = "material"
gravity_direction = "transverse"
"""
TABLE = STEM + """[source]
file = "a.txt"
[time]
column = "t"
unit = "ms"
release_s = "detect"
[motion]
unit = "cm"
sign = -1
zero = "before_release"
[[height]]
height_mm = 100
columns = ["tip1", "4"]
[[height]]
height_mm = 50
columns = "middle"
"""
MARKERS = STEM + """[source]
file = "a.csv"
[time]
release_s = 0.2512
before_s = 0.1
after_s = 0.5
[motion]
axis = [-2, 0, 0]
zero = "before_release"
[clamp]
markers = "base"
[[height]]
height_mm = 100
markers = ["tip 1", "tip 2"]
"""
MOVING = STEM.replace("held_straight", "moving")
SENSOR = MOVING + """[source]
file = "a.csv"
[time]
column = "t"
[[sensor]]
column = "acc (g)"
quantity = "acceleration"
unit = "g"
height_mm = 90
mass_g = 5
"""
RELEASE = 0.2512  # s, between two frames of 1/200 s
LEVEL = 50.0  # mm


def travel(time):
    """Position in mm: held at a level, then swinging about 10 mm below it."""
    t = time - RELEASE
    return 0.0 if t <= 0.0 else 10.0 * (1.0 - math.exp(-3.0 * t) * math.cos(10.0 * math.pi * t))


def unevenness(i):
    """Small, and the same in every run."""
    return 0.01 * math.sin(37.0 * i + 1.0)


def beam_table(delimiter=",", decimal="."):
    lines = [delimiter.join(["t", "tip1", "middle", "tip 2"])]
    for i in range(200):
        x = LEVEL - travel(i / 200) + unevenness(i)
        cells = (5.0 * i, 0.1 * (x + 1.0),
                 0.1 * (LEVEL - 0.3 * travel(i / 200) + unevenness(i + 1000)), 0.1 * (x - 1.0))
        lines.append(delimiter.join(f"{cell!r}".replace(".", decimal) for cell in cells))
    return "\n".join(lines) + "\n"


def marker_table():
    lines = ["t," + ",".join(f"{m} {a}" for m in ("base", "tip 1", "tip 2") for a in "xyz")]
    for i in range(200):
        time = i / 200
        shake = 0.5 * math.sin(40.0 * time)  # mm, motion of the whole set-up
        x = LEVEL - travel(time) + unevenness(i) + shake
        values = (LEVEL + shake, 3.0, 0.0, x + 5.0, 3.0, 90.0, x - 5.0, 3.0, 95.0)
        lines.append(f"{time}," + ",".join(repr(1e-3 * value) for value in values))
    return "\n".join(lines) + "\n"


def swinging_table(amplitude):
    """A swing of 5 Hz, 400 frames at 200/s."""
    dice = random.Random(3)
    lines = ["t;tip1;4;middle"]
    for i in range(400):
        swing = amplitude * math.cos(10.0 * math.pi * i / 200)
        tip = 0.1 * (swing + dice.gauss(0.0, 0.01))
        lines.append(f"{5 * i};{tip};{tip};{0.1 * (0.3 * swing + dice.gauss(0.0, 0.01))}")
    return "\n".join(lines) + "\n"


@unittest.skipUnless(TRACK, "CULM_TRACK names no program")
class Imports(RecordingFiles):
    def run_import(self, mapping, name, recording):
        self.file(name, recording)
        return self.ran(import_recording, self.file("mapping.toml", mapping), self.folder / "out",
                        "--culm-track", TRACK)

    def imported(self, mapping, name, recording):
        """Header and rows; self.stem, self.notes and self.printed."""
        code, self.printed, self.notes = self.run_import(mapping, name, recording)
        self.assertEqual(code, 0, self.notes)
        self.stem = tomllib.loads((self.folder / "out/stem.toml").read_text("utf-8"))
        with open(self.folder / "out/deflection.csv", encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
        return header, [[float(cell) if cell else None for cell in row] for row in rows]

    def refusal(self, mapping, name, recording):
        code, out, err = self.run_import(mapping, name, recording)
        self.assertEqual((code, out), (2, ""), err)
        self.assertFalse((self.folder / "out/stem.toml").exists())
        return err


class Measurements(Imports):
    def expect_the_beam(self, mapping, recording):
        header, rows = self.imported(mapping, "a.txt", recording)
        self.assertEqual(header, ["time_s", "h=50mm", "h=100mm"])
        self.assertEqual(len(rows), 200)
        found = -rows[0][0]
        self.assertAlmostEqual(found, RELEASE, delta=1.0 / 200.0)
        for row in rows:
            expected = travel(row[0] + found)
            self.assertAlmostEqual(row[2], expected, delta=0.015)
            self.assertAlmostEqual(row[1], 0.3 * expected, delta=0.015)
        noise = self.stem["measurement"]["noise_by_height_mm"]
        self.assertAlmostEqual(noise[1], 0.01 / math.sqrt(2.0), delta=1e-3)
        self.assertIn("frames before the release", self.stem["measurement"]["noise_source"])

    def test_tables_of_any_delimiter_and_decimal_sign(self):
        self.expect_the_beam(TABLE, beam_table())
        self.expect_the_beam(TABLE, beam_table("\t"))
        self.expect_the_beam(TABLE, beam_table(";", ","))
        self.assertIn("the decimal sign is a comma   ([source] decimal)", self.printed)
        self.expect_the_beam(TABLE.replace("[time]", 'decimal = ","\n[time]'), beam_table(";", ","))
        self.assertNotIn("decimal", self.printed)

    def test_markers_along_an_axis_less_the_motion_of_the_clamp(self):
        _, rows = self.imported(MARKERS, "a.csv", marker_table())
        self.assertAlmostEqual(self.stem["camera"]["fps"], 200.0, places=6)
        self.assertEqual(len(rows), 120)
        for time, deflection in rows:
            self.assertTrue(-0.1 <= time <= 0.5)
            self.assertAlmostEqual(deflection, travel(time + RELEASE), delta=0.02)

    def test_a_marker_at_the_origin_was_not_seen(self):
        lines = marker_table().splitlines()
        cells = lines[121].split(",")
        lines[121] = ",".join(cells[:4] + ["0", "0", "0"] + cells[7:])
        _, rows = self.imported(MARKERS, "a.csv", "\n".join(lines))
        self.assertEqual(sum(row[1] is None for row in rows), 1)
        self.assertIn('marker "tip 1": 1 position at 0, 0, 0 (line 122)', " ".join(self.printed.split()))

    def test_a_sensor_keeps_its_unit(self):
        table = "t,acc (g)\n5,1\n5.1,-2\n5.2,1.5\n5.3,0.5\n"
        header, rows = self.imported(SENSOR, "a.csv", table)
        self.assertEqual(header, ["time_s", "acc (g)"])
        self.assertEqual(rows, [[5.0, 1.0], [5.1, -2.0], [5.2, 1.5], [5.3, 0.5]])
        self.assertEqual(self.stem["sensor"][0]["mass_g"], 5)

    def test_a_stated_noise_becomes_that_of_the_means(self):
        table = "t,acc (g)\n" + "".join(f"{5.0 + 0.01 * k:.2f},{math.sin(k):.6f}\n" for k in range(80))
        mapping = SENSOR.replace("[time]", "[time]\nreadings_per_mean = 4")
        mapping = mapping.replace("mass_g = 5", "mass_g = 5\nnoise = 0.02")
        mapping = mapping.replace("[measurement]", "[measurement]\nnoise_correlation = 0.5")
        _, rows = self.imported(mapping, "a.csv", table)
        self.assertAlmostEqual(rows[0][1], sum(math.sin(k) for k in range(4)) / 4.0, delta=1e-5)
        self.assertAlmostEqual(rows[1][0] - rows[0][0], 0.04, delta=1e-9)
        # Sums of the covariances of four readings, and of those with the next four.
        correlation = [0.5 ** abs(i - j) for i in range(4) for j in range(4)]
        between = [0.5 ** (4 + j - i) for i in range(4) for j in range(4)]
        self.assertAlmostEqual(self.stem["sensor"][0]["noise"],
                               0.02 * math.sqrt(sum(correlation)) / 4.0, delta=1e-9)
        self.assertAlmostEqual(self.stem["measurement"]["noise_correlation"],
                               sum(between) / sum(correlation), delta=1e-6)

    def test_heights_and_sensors_are_sorted_together(self):
        mapping = TABLE + ('[[sensor]]\ncolumn = "5"\nquantity = "velocity"\nunit = "mm/s"\n'
                           "height_mm = 70\n")
        lines = beam_table().splitlines()
        table = "\n".join([lines[0] + ",v"] + [f"{line},{12.0 + 0.5 * (k % 2)}"
                                               for k, line in enumerate(lines[1:])])
        header, rows = self.imported(mapping, "a.txt", table)
        self.assertEqual(header, ["time_s", "h=50mm", "5", "h=100mm"])
        self.assertEqual(rows[7][2], 12.5)
        self.assertAlmostEqual(self.stem["measurement"]["noise_mm"], 0.01 / math.sqrt(2.0), delta=1e-3)
        self.assertIn("noise", self.stem["sensor"][0])

    def test_digits_of_a_stated_number_are_kept(self):
        self.imported(TABLE.replace("length_mm = 100", "length_mm = 100.00"), "a.txt", beam_table())
        self.assertIn("length_mm = 100.00\n", (self.folder / "out/stem.toml").read_text("utf-8"))

    def test_no_noise_is_estimated_from_frames_that_move(self):
        mapping = TABLE.replace('"detect"', "0.895")
        self.imported(mapping, "a.txt", swinging_table(14.1))
        self.assertNotIn("noise_by_height_mm", self.stem["measurement"])
        self.assertIn("the stem moves in the 179 frames before the release", self.notes)
        self.assertIn('set zero = "at_rest" or "as_given"', self.notes)
        self.imported(mapping, "a.txt", swinging_table(0.0))
        self.assertEqual(self.stem["measurement"]["noise_source"],
                         "scatter of 179 frames before the release")

    def test_gaps_in_time_are_counted(self):
        lines = beam_table().splitlines()
        self.imported(TABLE, "a.txt", "\n".join(lines[:100] + lines[101:150] + lines[154:]))
        self.assertIn("2 gaps in time, the longest 25 ms", self.printed)

    def test_a_wrong_unit_of_time_is_doubted(self):
        mapping = TABLE.replace('unit = "ms"', 'unit = "us"').replace(
            'release_s = "detect"', "release_s = 0.0002512").replace(
                "height_mm = 30", "height_mm = 3", 1)
        self.imported(mapping, "a.txt", beam_table())
        self.assertIn('with [time] unit = "ms" it would be plausible', self.notes)

    def test_a_swing_that_is_not_about_zero_is_noted(self):
        self.imported(TABLE.replace('"before_release"', '"as_given"'), "a.txt", beam_table())
        self.assertIn('set [motion] zero = "at_rest"', self.notes)

    def test_the_zero_at_rest_is_the_centre_of_a_swing_that_has_not_ended(self):
        _, rows = self.imported(TABLE.replace('"before_release"', '"at_rest"'), "a.txt", beam_table())
        self.assertAlmostEqual(rows[0][2], -10.0, delta=0.05)


class Mistakes(Imports):
    def complaint(self, mapping, before, after, name, recording):
        self.assertIn(before, mapping)
        return self.refusal(mapping.replace(before, after), name, recording)

    def test_are_named_with_the_nearest_name(self):
        markers, table = marker_table(), beam_table()
        for mapping, before, after, name, recording, reason in (
                (MARKERS, "tip 2", "tip2", "a.csv", markers,
                 'there is no marker "tip2" (did you mean "tip 2"?)'),
                (MARKERS, "0.2512", "7", "a.csv", markers, "nothing was recorded after the release"),
                (MARKERS, "axis = [-2, 0, 0]", "", "a.csv", markers, "belongs to files with markers"),
                (TABLE, "middle", "midle", "a.txt", table,
                 'there is no column "midle" (did you mean "middle"?)'),
                (TABLE, '"ms"', '"frame"', "a.txt", table, "frame numbers need [camera] fps"),
                (TABLE, "sign = -1", "sgn = -1", "a.txt", table,
                 "mapping.toml:22: motion.sgn = -1: unknown key (did you mean sign?)"),
                (TABLE, "sign = -1", 'release_s = "detect"', "a.txt", table,
                 "it belongs into [time]"),
                (TABLE, "height_mm = 50", "height_mm = 500", "a.txt", table,
                 "mapping.toml:28: height.height_mm = 500: lies above the stem"),
                (TABLE, '"detect"', "0", "a.txt", "t,tip1,middle,tip 2\n0,1,2,x\n1,2,3,y\n2,3,4,z\n",
                 'column "tip 2" contains text, such as "x"')):
            with self.subTest(reason):
                self.assertIn(reason, self.complaint(mapping, before, after, name, recording))

    def test_all_are_listed_with_their_lines(self):
        mapping = TABLE.replace('unit = "ms"', 'unit = "mss"').replace('unit = "cm"', "unit = 3")
        reason = self.refusal(mapping, "a.txt", beam_table())
        self.assertIn('mapping.toml:18: time.unit = "mss": must be one of "s", "ms"', reason)
        self.assertIn("mapping.toml:21: motion.unit = 3: must be a text in quotes", reason)

    def test_numbers_of_heights_and_columns_are_bounded(self):
        many = TABLE + '[[height]]\nheight_mm = 1\ncolumns = "middle"\n' * 10_000
        self.assertIn("at most 10000", self.refusal(many, "a.txt", "t\n"))
        wide = TABLE + "[[height]]\nheight_mm = 1\ncolumns = [" + '"middle",' * 1001 + "]\n"
        self.assertIn("1001 names; at most 1000 are allowed", self.refusal(wide, "a.txt", "t\n"))

    def test_a_release_is_not_guessed(self):
        still = "t,tip1,middle,tip 2\n" + "".join(
            f"{5 * i},{5.0 + 0.1 * unevenness(i)},5,5\n" for i in range(100))
        self.assertIn("no release was found", self.refusal(TABLE, "a.txt", still))

    def test_a_recording_is_in_the_folder_of_its_mapping(self):
        self.assertIn("--recording", self.complaint(TABLE, '"a.txt"', '"../a.txt"', "a.txt", ""))


if __name__ == "__main__":
    unittest.main()
