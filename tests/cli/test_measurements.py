# SPDX-License-Identifier: BSD-3-Clause
"""`culm import` and `culm fit` on the command line."""

import csv
import json
import math
import shutil
import sys
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, POINTS_FAILED, CulmTest

TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "support"))
from json_schema import schema_faults, schema_of  # noqa: E402

EXAMPLES = TESTS / "data" / "measurements"
SCHEMA = schema_of("fit")
# Mode 1 of the two stems (tests/data/measurements/README.md).
TRUTH = {"S01": (36.007, 0.6471), "S10": (57.410, 0.7945)}

MAPPING = """
[source]
file = "beam.csv"
[time]
column = "t"
release_s = "detect"
[motion]
unit = "mm"
sign = -1
zero = "before_release"
[[height]]
height_mm = 100
columns = "tip"
[stem]
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


class Fit(CulmTest):
    def fit(self, *arguments):
        finished = self.culm("fit", *arguments, "--json", "fit.json")
        self.assert_exit(finished, DONE)
        result = json.loads((self.folder / "fit.json").read_text("utf-8"))
        self.assertEqual(schema_faults(result, SCHEMA), [])
        return finished, result

    def test_finds_frequency_and_decay_of_the_null_stem(self):
        finished, result = self.fit(str(EXAMPLES / "T1-null"), "--phase", "free")
        stem, = result["stems"]
        self.assertIsNone(result["population"])
        # The truth is 86.1974 Hz without damping and 0.26 per cycle; large deflections lower both.
        self.assertAlmostEqual(stem["natural_frequency_hz"], 86.197, delta=0.2)
        self.assertAlmostEqual(-stem["b1_per_cycle"]["value"], 0.26, delta=0.003)
        self.assertLess(len(finished.stdout.splitlines()), 20)
        self.assertIn("banding:", finished.stdout)

    def test_summarises_the_population_of_a_folder_of_stems(self):
        finished, result = self.fit(str(EXAMPLES), "--phase", "free", "-o", "out")
        self.assertEqual([stem["measurement"] for stem in result["stems"]], ["S01", "S10", "T1"])
        self.assertEqual(result["population"]["stems"], 3)
        for stem in result["stems"]:
            if stem["measurement"] in TRUTH:
                frequency, decay = TRUTH[stem["measurement"]]
                self.assertAlmostEqual(stem["natural_frequency_hz"] / frequency, 1, delta=0.005)
                self.assertAlmostEqual(-stem["b1_per_cycle"]["value"] / decay, 1, delta=0.015)
        self.assertIn("3 stems", finished.stdout)
        self.assertEqual(json.loads((self.folder / "out/fit.json").read_text("utf-8")), result)

    def test_summarises_stems_as_a_population(self):
        _, result = self.fit(str(EXAMPLES / "S01"), str(EXAMPLES / "S10"), "--phase", "free")
        population = result["population"]
        self.assertEqual(population["stems"], 2)
        for key, truths, part in (("natural_frequency_hz", (36.007, 57.410), 0.003),
                                  ("b1_per_cycle", (-0.6471, -0.7945), 0.015)):
            values = [stem[key]["value"] if key == "b1_per_cycle" else stem[key]
                      for stem in result["stems"]]
            self.assertAlmostEqual(population[key]["mean"], sum(values) / 2)
            self.assertAlmostEqual(population[key]["standard_deviation"],
                                   abs(values[0] - values[1]) / math.sqrt(2))
            # Large deflections increase the fitted decay by one per cent.
            self.assertAlmostEqual(population[key]["mean"] / (sum(truths) / 2), 1, delta=part)

    def test_writes_normalised_histories(self):
        self.fit(str(EXAMPLES / "T1-null"), "-o", "out")
        with (self.folder / "out/normalised/001.csv").open(newline="") as lines:
            header, *rows = csv.reader(lines)
        self.assertEqual(header[:2], ["cycles", "h=14mm"])
        values = [[float(cell) for cell in row] for row in rows]
        self.assertAlmostEqual(max(abs(x) for row in values for x in row[1:]), 1.0, places=6)
        # One cycle after the release the tip is back on its side, smaller by exp(-0.26).
        after = min(values, key=lambda row: abs(row[0] - 1.0))
        self.assertAlmostEqual(after[-1], math.exp(-0.26), delta=0.05)

    def test_prints_nothing_else_with_json_on_stdout(self):
        finished = self.culm("fit", str(EXAMPLES / "S01"), "--json", "-")
        self.assert_exit(finished, DONE)
        self.assertEqual(schema_faults(json.loads(finished.stdout), SCHEMA), [])

    def test_reads_everything_before_it_fits_and_reports_all_errors(self):
        for name in ("a", "b"):
            shutil.copytree(EXAMPLES / "S01", self.folder / "stems" / name)
        table = self.folder / "stems/a/deflection.csv"
        table.write_text(table.read_text("utf-8").replace(",", ";"), "utf-8")
        stem = self.folder / "stems/b/stem.toml"
        stem.write_text(stem.read_text("utf-8").replace("diameter_mm", "diametre_mm"), "utf-8")
        finished = self.culm("fit", "stems")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("stems/a/deflection.csv:1: cells are not separated by commas",
                      finished.stderr)
        self.assertIn("stems/b/stem.toml:4: stem.diametre_mm = 2.67: unknown key (did you "
                      "mean diameter_mm?)", finished.stderr)

    def test_names_a_stem_that_does_not_swing(self):
        shutil.copytree(EXAMPLES / "S01", self.folder / "still")
        (self.folder / "still/deflection.csv").write_text(
            "time_s,h=14mm\n" + "".join(f"{i / 960},1\n" for i in range(50)), "utf-8")
        finished = self.culm("fit", "still", str(EXAMPLES / "T1-null"))
        self.assert_exit(finished, POINTS_FAILED)
        self.assertIn("S01            no height could be fitted", finished.stdout)

    def test_refuses_a_missing_folder(self):
        self.assert_refused(self.culm("fit", "nowhere"),
                            "culm: nowhere: there is no such folder\n")


class Import(CulmTest):
    def write_beam(self):
        lines = ["t,tip"]
        for i in range(400):
            time = i / 100 - 0.5
            travel = 0.0
            if time > 0:
                travel = 10 * (1 - math.exp(-2 * time) * math.cos(2 * math.pi * 7 * time))
            lines.append(f"{i / 100:.2f},{50 - travel + 0.005 * math.sin(37 * i):.6f}")
        self.write("beam.csv", "\n".join(lines) + "\n")
        self.write("mapping.toml", MAPPING)

    def test_makes_a_measurement_that_fit_takes(self):
        self.write_beam()
        finished = self.culm("import", "mapping.toml", "-o", "beam")
        self.assert_exit(finished, DONE)
        self.assertIn("beam: 1 height, 400 frames", finished.stdout)
        self.assertIn("noise: scatter of", finished.stdout)
        finished = self.culm("fit", "beam", "--json", "-")
        self.assert_exit(finished, DONE)
        height, = json.loads(finished.stdout)["stems"][0]["heights"]
        # The motion begins with 20 mm/s, so the onset is found 1 ms too early.
        self.assertAlmostEqual(height["b2_hz"]["value"], 7.0, delta=0.03)
        self.assertAlmostEqual(height["b1_per_s"]["value"], -2.0, delta=0.1)
        self.assertAlmostEqual(height["offset_mm"]["value"], 10.0, delta=0.01)

    def test_says_which_column_is_missing(self):
        self.write_beam()
        self.write("mapping.toml", MAPPING.replace('"tip"', '"top"'))
        self.assert_refused(
            self.culm("import", "mapping.toml", "-o", "beam"),
            'culm: beam.csv: there is no column "top" (did you mean "tip"?); it has "t", "tip"\n')

    def test_says_which_file_is_missing(self):
        self.write("mapping.toml", MAPPING)
        self.assert_refused(self.culm("import", "mapping.toml", "-o", "beam"),
                            "culm: beam.csv: cannot be read: No such file or directory\n")


if __name__ == "__main__":
    unittest.main()
