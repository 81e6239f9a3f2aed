# SPDX-License-Identifier: BSD-3-Clause
"""Proposed mappings state what a recording contains and leave the rest to the user."""
import math
import tomllib
import unittest
from pathlib import Path

import import_recording
from recording.columns import sensor_of
from recording_files import RecordingFiles

RECORDINGS = Path(__file__).resolve().parents[1] / "data/recordings"


def swing(n):
    return 3.0 * math.exp(-0.002 * n) * math.cos(0.25 * n)


def rows(separator=",", decimal=".", held=0, count=200):
    lines = (f"{n / 1000:.3f}{separator}{swing(max(0, n - held)):.5f}" for n in range(count))
    return "\n".join(lines).replace(".", decimal) + "\n"


class Proposals(RecordingFiles):
    def setUp(self):
        super().setUp()
        self.output = self.folder / "out"

    def run_program(self, recording):
        return self.ran(import_recording, recording, self.output)

    def proposal(self, recording):
        """The mapping; self.printed and self.text are the printed lines and the mapping's text."""
        code, out, err = self.run_program(recording)
        self.assertEqual((code, err), (0, ""))
        self.printed = out.splitlines()
        self.assertLessEqual(len(self.printed), 18)
        self.assertIn(f"culm import {self.output}/import.toml -o {self.output}", self.printed[-1])
        self.text = (self.output / "import.toml").read_text("utf-8")
        self.assertLessEqual(max(map(len, self.text.splitlines())), 100)
        return tomllib.loads(self.text)

    def proposal_of(self, content, name="log.csv"):
        return self.proposal(self.file(name, content))

    def refusal(self, recording):
        code, out, err = self.run_program(recording)
        self.assertEqual((code, out, err.count("\n")), (2, "", 1), err)
        return err


class Examples(Proposals):
    def test_accelerometer_completed(self):
        mapping = self.proposal(RECORDINGS / "accelerometer.csv")
        self.assertEqual(mapping["release"], {"kind": "moving"})
        self.assertNotIn("height_mm", mapping["sensor"][0])
        text = self.text
        sensor, stem = text.split("[stem]")
        for key, value in (("height_mm", 140), ("mass_g", 5)):
            sensor = sensor.replace(f"# {key} = ", f"{key} = {value} ")
        for key, value in (("length_mm", 150), ("density_kg_m3", 2700), ("width_mm", 10),
                           ("height_mm", 1)):
            self.assertIn(f"# {key} = ", stem)
            stem = stem.replace(f"# {key} = ", f"{key} = {value} ")
        stem = stem.replace("# [section]", "[section]").replace("# shape", "shape")
        self.assertEqual(tomllib.loads(sensor + "[stem]" + stem), {
            "source": {"file": "accelerometer.csv", "delimiter": ","},
            "time": {"column": "time_s", "unit": "s"}, "release": {"kind": "moving"},
            "sensor": [{"column": "acc_g", "quantity": "acceleration", "unit": "g",
                        "height_mm": 140, "mass_g": 5}],
            "stem": {"id": "accelerometer", "length_mm": 150, "density_kg_m3": 2700},
            "section": {"shape": "rectangle", "width_mm": 10, "height_mm": 1}})
        self.assertEqual((self.output / "accelerometer.csv").read_bytes(),
                         (RECORDINGS / "accelerometer.csv").read_bytes())

    def test_every_commented_key_says_what_it_is(self):
        self.proposal_of("t;strain;acc\n" + "".join(
            f"{n};{n % 3};{n % 5}\n" for n in range(40)))
        keys = [line for line in self.text.splitlines() if line.startswith("# ") and " = " in line]
        self.assertEqual(len(keys), 12)  # two units, two heights, mass, distance, stem, section
        for line in keys:
            self.assertRegex(line, r"# \w+ = .*# [\w\"]+")

    def test_laser(self):
        mapping = self.proposal(RECORDINGS / "laser.csv")
        self.assertEqual(mapping["time"],
                         {"column": "Time (s)", "unit": "s", "release_s": "detect"})
        self.assertEqual(mapping["sensor"], [{"column": "Displacement (mm)",
                                              "quantity": "displacement", "unit": "mm"}])

    def test_matlab_without_units(self):
        mapping = self.proposal(RECORDINGS / "matlab_recording.mat")
        self.assertEqual(mapping["source"], {"file": "matlab_recording.mat"})
        self.assertTrue((self.output / "matlab_recording.mat").is_file())
        self.assertEqual([h["columns"] for h in mapping["height"]], ["x 1", "x 2"])
        self.assertEqual(self.text.count("# unit = "), 1)
        self.assertEqual(mapping["motion"], {"zero": "at_rest"})
        self.assertIn("unit, height_mm", self.printed[-2])

    def test_tracker_is_in_the_unit_of_its_scale(self):
        mapping = self.proposal(RECORDINGS / "tracker.trk")
        self.assertEqual(mapping["time"], {"column": "t", "unit": "s", "release_s": "detect"})
        self.assertEqual(mapping["height"][0], {"columns": "tip x"})
        self.assertEqual(mapping["motion"], {"unit": "m", "zero": "at_rest"})
        self.assertEqual(mapping["measurement"], {"reading": "material"})
        self.assertIn('"clamp x"', self.text)  # constant
        self.assertIn("the project's scale", self.text)

    def test_dice_counts_frames_below_its_heading(self):
        mapping = self.proposal(RECORDINGS / "dice_point.txt")
        self.assertEqual(mapping["source"]["skip_lines"], 20)
        self.assertEqual(mapping["time"],
                         {"column": "FRAME", "unit": "frame", "release_s": "detect"})
        self.assertEqual(mapping["camera"], {})
        self.assertIn("# fps = ", self.text)
        self.assertEqual(mapping["height"], [{"columns": "DISPLACEMENT_X"},
                                             {"columns": "DISPLACEMENT_Y"}])
        self.assertNotIn("sensor", mapping)
        self.assertIn('"GAMMA"', self.text.split("not used:")[1])


class Tables(Proposals):
    def test_strip_that_moves(self):
        mapping = self.proposal_of("time_s,acc_g\n" + rows())
        self.assertEqual(mapping["release"], {"kind": "moving"})
        self.assertNotIn("release_s", mapping["time"])
        self.assertIn("log.csv: 200 samples, 1000 Hz, 0.199 s", self.printed)

    def test_a_table_in_the_folder_is_used_where_it_is(self):
        self.output = self.folder
        (self.folder / "raw").mkdir()
        place = self.file("raw/log.csv", "time_s,disp_mm\n" + rows(held=50))
        self.assertEqual(self.proposal(place)["source"]["file"], "raw/log.csv")
        self.assertFalse((self.folder / "log.csv").exists())

    def test_decimal_commas(self):
        mapping = self.proposal_of("# log\nZeit [ms];Weg [µm]\n" + rows(";", ",", held=50))
        self.assertEqual(mapping["source"],
                         {"file": "log.csv", "delimiter": ";", "decimal": ","})
        self.assertEqual(mapping["time"],
                         {"column": "Zeit [ms]", "unit": "ms", "release_s": "detect"})
        self.assertEqual(mapping["motion"]["unit"], "um")

    def test_without_header_columns_are_numbers(self):
        for separator, name in ((",", ","), ("\t", "tab"), ("   ", "space")):
            with self.subTest(name):
                self.output = self.folder / name
                mapping = self.proposal_of(rows(separator))
                self.assertEqual(mapping["source"]["delimiter"], name)
                self.assertEqual(mapping["time"]["column"], "1")
                self.assertEqual(mapping["sensor"][0]["column"], "2")
                self.assertIn("# a guess: the name does not state it", self.text)
                self.assertIn("# a guess; s, ms, us, ns, min, h, day or frame", self.text)

    def test_a_number_is_not_taken_for_a_cell_of_the_first_line(self):
        mapping = self.proposal_of("1,2\n2,5\n3,4\n")
        self.assertEqual((mapping["time"]["column"], mapping["sensor"][0]["column"]), ("01", "02"))

    def test_other_columns_and_texts_are_listed(self):
        names = ",".join(f"x{k}" for k in range(10))
        mapping = self.proposal_of(f"i,t,note,{names}\n" + "".join(
            f"{n},{n / 10},ok,{','.join(str((n * k) % 7 + n % 2) for k in range(10))}\n"
            for n in range(30)))
        self.assertEqual(mapping["time"]["column"], "t")
        self.assertEqual(len(mapping["height"]), 8)
        self.assertRegex(self.text, r'# Columns that are not used: "i", "note", .*"x9"')

    def test_quantities_and_units_of_names(self):
        for name, expected in {
                "acc_g": ("acceleration", "g"), "a_x (m/s²)": ("acceleration", "m/s2"),
                "accel [mm/s^2]": ("acceleration", "mm/s2"), "v_tip (mm/s)": ("velocity", "mm/s"),
                "vel_m/s": ("velocity", "m/s"), "Strain (µε)": ("strain", "um/m"),
                "eps ustrain": ("strain", "um/m"), "strain_m/m": ("strain", "m/m"),
                "laser_um": ("displacement", "um"), "Position (cm)": ("displacement", None),
                "channel 3 (m/s2)": ("acceleration", "m/s2"), "x": ("displacement", None),
                "acc (mm)": ("acceleration", None)}.items():
            with self.subTest(name):
                sensor = sensor_of(name, None, None)
                self.assertEqual((sensor.quantity, sensor.unit, sensor.is_guess),
                                 (*expected, False))
        self.assertTrue(sensor_of("channel 3", None, None).is_guess)


class Refusals(Proposals):
    def test_an_existing_mapping_is_kept(self):
        self.proposal(RECORDINGS / "laser.csv")
        (self.output / "import.toml").write_text("mine", "utf-8")
        self.assertIn("is not overwritten", self.refusal(RECORDINGS / "laser.csv"))
        self.assertEqual((self.output / "import.toml").read_text("utf-8"), "mine")

    def test_an_existing_table_of_the_name_is_kept(self):
        self.output.mkdir()
        (self.output / "laser.csv").write_text("mine", "utf-8")
        self.assertIn("other content", self.refusal(RECORDINGS / "laser.csv"))
        self.assertFalse((self.output / "import.toml").exists())

    def test_bad_files(self):
        for name, content, reason in (
                ("a.c3d", b"\x02\x50", "config/measurements/c3d.toml"),
                ("a.csv", "", "file is empty"),
                ("b.csv", "time_s,x\n", "no two lines"), ("c.csv", b"a\0b", "not a text file"),
                ("d.csv", b"\xff\xfet\0", "no two lines"), ("e.xlsx", b"PK\x03\x04", "workbook"),
                ("f.csv", "t,x\n1,2\n1,3\n", 'the time column "t" never changes'),
                ("j.csv", "a,x\n1,3\n1,3\n", "readings that vary"),
                ("g.csv", "t,x\n1,2\n2,2\n", "readings that vary"),
                ("h.trk", "x", "not XML")):
            with self.subTest(name):
                self.assertIn(reason, self.refusal(self.file(name, content)))
        self.assertIn("No such file", self.refusal(self.folder / "none.csv"))
        self.assertFalse(self.output.exists())


if __name__ == "__main__":
    unittest.main()
