#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Files as people have them give the right answer, or a refusal that names cause, place and remedy.

Each folder of tests/data/field imitates a report in public (its README.md)."""
import csv
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tomllib
import unittest
from pathlib import Path

from culm_program import (BAD_INPUT, DONE, PATIENCE, POINTS_FAILED, PROGRAM, QUICK, CulmTest,
                          launcher)

FIELD = Path(__file__).resolve().parents[1] / "data/field"


def without_line_breaks(text: str) -> str:
    return " ".join(text.split())


class FieldFiles(CulmTest):
    def folder_of(self, name: str):
        shutil.copytree(FIELD / name, self.folder, dirs_exist_ok=True)

    def imported(self, mapping: str, output: str = "out") -> str:
        finished = self.culm("import", mapping, "-o", output)
        self.assert_exit(finished, DONE)
        return without_line_breaks(finished.stdout + finished.stderr)

    def refused(self, mapping: str) -> str:
        finished = self.culm("import", mapping, "-o", "out")
        self.assertEqual(finished.returncode, BAD_INPUT, finished.stdout)
        self.assertFalse((self.folder / "out/deflection.csv").exists())
        return without_line_breaks(finished.stderr)

    def rows(self, output: str = "out") -> list[list[str]]:
        with open(self.folder / output / "deflection.csv", encoding="utf-8", newline="") as file:
            return list(csv.reader(file))

    def release_in_source(self, printed: str) -> float:
        return float(re.search(r"released at (\S+) s", printed)[1])

    def proposed(self, recording: str, **values: str) -> str:
        """The output of the proposal; its commented keys are completed."""
        finished = self.culm("import", recording, "-o", "out")
        self.assert_exit(finished, DONE)
        mapping = self.folder / "out/import.toml"
        sensors, stem = mapping.read_text("utf-8").split("[stem]")
        values |= {"height_mm": "140", "length_mm": "150", "density_kg_m3": "2700"}
        for key, value in values.items():
            sensors = re.sub(rf"(?m)^# {key} = *", f"{key} = {value} ", sensors)
        for key in ("length_mm", "density_kg_m3"):
            stem = stem.replace(f"# {key} =", f"{key} = {values[key]}")
        stem = (stem.replace("# [section]", "[section]").replace("# shape", "shape")
                .replace("# width_mm =", "width_mm = 10").replace("# height_mm =", "height_mm = 1"))
        mapping.write_text(sensors + "[stem]" + stem, "utf-8")
        return without_line_breaks(finished.stdout)

    def frequency(self, *options: str) -> float:
        self.assert_exit(self.culm("fit", "out", *options, "--json", "fit.json"), DONE)
        fits = json.loads((self.folder / "fit.json").read_text("utf-8"))
        return fits["stems"][0]["b2_hz"]["value"]

    def calibrated(self, output: str) -> dict:
        self.assert_exit(self.culm("calibrate", output, "--json", "found.json"), DONE)
        return json.loads((self.folder / "found.json").read_text("utf-8"))["stems"][0][
            "parameters"]


class Tables(FieldFiles):
    def test_03_a_labview_log_has_lines_of_numbers_above_its_table(self):
        self.folder_of("03-labview-lvm")
        printed = self.proposed("one_time_column.lvm")
        self.assertIn("X_Value: time in s", printed)
        self.assertIn("Tip laser: displacement in mm", printed)
        self.assertIn("the table begins at line 24", printed)
        self.assertAlmostEqual(self.release_in_source(self.imported("out/import.toml")), 0.1,
                               delta=1e-4)
        self.assertEqual(len(self.rows()), 601)

    def test_04_of_a_workspace_the_recording_is_read(self):
        self.folder_of("04-mat-workspace")
        printed = self.proposed("run1.mat")
        self.assertIn("tip: displacement", printed)
        self.assertIn("others are not read: f, amp, phase, psd (401 values)", printed)
        shutil.rmtree(self.folder / "out")
        self.imported("mapping.toml")
        self.assertEqual(len(self.rows()), 801)
        self.assertAlmostEqual(self.frequency("--phase", "free"), 36.55, delta=0.02)

    def test_05_nanoseconds_since_1970_are_no_seconds(self):
        self.folder_of("05-sensor-logger-ns")
        self.assertIn("seconds_elapsed: time in s", self.proposed("Accelerometer.csv"))
        shutil.rmtree(self.folder / "out")
        reason = self.refused("mapping.toml")
        self.assertIn('column = "time", unit = "s": a sampling interval of 1e+07 s', reason)
        self.assertIn('unit = "ns" (nanoseconds since 1970) it would be 0.01 s', reason)

    def test_06_stamps_that_repeat_are_counted_and_repaired_on_request(self):
        self.folder_of("06-duplicate-timestamps")
        reason = self.refused("mapping.toml")
        for part in ("one in 10.9", "lines 3, 14, 25", "rounded to 1 ms", 'repeated_times = "spread"',
                     '"drop"', "rate_hz = 1100 "):
            self.assertIn(part, reason)
        mapping = (self.folder / "mapping.toml").read_text("utf-8")
        for key, rows in (('repeated_times = "spread"', 600), ('repeated_times = "drop"', 545)):
            (self.folder / "mapping.toml").write_text(
                mapping.replace("[time]", f"[time]\n{key}"), "utf-8")
            printed = self.imported("mapping.toml")
            self.assertEqual(len(self.rows()) - 1, rows)
            self.assertAlmostEqual(self.release_in_source(printed), 0.05, delta=6e-4)

    def test_07_times_since_1970_count_from_the_first(self):
        self.folder_of("07-epoch-times")
        self.assertIn("1795769012.512", self.imported("moving.toml"))
        stem = tomllib.loads((self.folder / "out/stem.toml").read_text("utf-8"))
        self.assertAlmostEqual(stem["release"]["start_s"], 0.988, places=6)
        self.imported("release.toml")
        self.assertAlmostEqual(float(self.rows()[1][0]), -0.088, places=6)
        self.assertAlmostEqual(self.frequency("--phase", "free"), 4.57, delta=0.02)

    def test_20_a_pull_by_hand_is_not_the_release(self):
        self.folder_of("20-hand-pull-release")
        self.assertAlmostEqual(self.release_in_source(self.imported("mapping.toml")), 4.0, delta=0.02)
        stem = tomllib.loads((self.folder / "out/stem.toml").read_text("utf-8"))
        for noise in stem["measurement"]["noise_by_height_mm"]:
            self.assertAlmostEqual(noise, 0.05, delta=0.01)


class InvalidReadings(FieldFiles):
    def test_08_rows_that_another_column_flags_are_gaps(self):
        self.folder_of("08-dice-failed-subset")
        printed = self.imported("mapping.toml")
        self.assertIn("14 rows with SIGMA < 0 are gaps (lines 82–88, 142–148)", printed)
        self.assertIn("[source] invalid_if", printed)
        empty = [row for row in self.rows() if row[1] == ""]
        self.assertEqual(len(empty), 14)
        low, high = self.calibrated("out")["bond_youngs_modulus_pa"]["interval"]
        self.assertTrue(low < 70e9 < high)

    def test_10_a_sensor_beyond_its_range_gives_the_damping_of_one_that_is_not(self):
        self.folder_of("10-clipped-accelerometer")
        printed = self.imported("mapping.toml")
        self.assertIn("readings are the end of the range (clipped?): -15.9744, 15.9666", printed)
        self.assertNotIn("clipped", self.imported("mapping_unclipped.toml", "whole"))
        clipped, whole = self.calibrated("out"), self.calibrated("whole")
        for number in ("bond_youngs_modulus_pa", "bond_damping"):
            low, high = clipped[number]["interval"]
            self.assertTrue(low < whole[number]["value"] < high, number)

    def test_11_an_overload_is_no_reading(self):
        self.folder_of("11-overload-sentinel")
        printed = self.imported("mapping.toml")
        self.assertIn("9.9e+37 marks", printed)
        self.assertIn("[source] missing_values", printed)
        self.assertNotIn("e+37", (self.folder / "out/deflection.csv").read_text("utf-8").lower())


class Stems(FieldFiles):
    def test_19_the_density_of_the_material_may_be_stated(self):
        self.folder_of("19-round-rod-density")
        stem = self.folder / "stem.toml"
        stem.write_text(stem.read_text("utf-8").replace("density_kg_m3", "material_density_kg_m3"),
                        "utf-8")
        low, high = self.calibrated(".")["bond_youngs_modulus_pa"]["interval"]
        self.assertTrue(low < 206e9 < high)

    def test_19_the_line_on_the_stem_tells_the_two_densities_apart(self):
        self.folder_of("19-round-rod-density")
        finished = self.culm("calibrate", ".", "--spheres", "12")
        self.assert_exit(finished, DONE)
        printed = " ".join(finished.stdout.split())
        self.assertIn("stem: 300 mm, 5 mm, 30.83 g (103 g/m as touching spheres of this density; "
                      "154 g/m as a rod), EI ", printed)

    def test_23_a_beat_of_two_planes_is_not_one_mode(self):
        self.folder_of("23-two-plane-beat")
        finished = self.culm("fit", ".", "--json", "-")
        self.assert_exit(finished, DONE)
        for height in json.loads(finished.stdout)["stems"][0]["heights"]:
            self.assertFalse(height["adequate"])
            self.assertTrue(36.5 < height["b2_hz"]["value"] < 37.7)

    def test_24_many_samples_are_averaged_and_said_so(self):
        rate, frequency, held = 51_200, 36.5562, 5_120
        chance = random.Random(1)
        times = [k / rate for k in range(60_000)]
        swing = [(k - held) / rate for k in range(60_000)]
        clean = [8.0 * math.exp(-9.0 * s) * math.cos(2.0 * math.pi * frequency * s) if s > 0.0
                 else 8.0 for s in swing]
        rows = [f"{t:.8f},{x + chance.gauss(0.0, 0.01):.5f}"
                for t, x in zip(times, clean, strict=True)]
        self.write("long.csv", "\n".join(["time_s,tip_mm", *rows]) + "\n")
        mapping = (FIELD / "24-million-samples/mapping.toml").read_text("utf-8")
        self.write("mapping.toml", mapping)
        printed = " ".join(self.imported("mapping.toml").split())
        self.assertRegex(printed, r"60000 readings, 1[34]\d\d per cycle, are averaged in groups of 3")
        self.assertIn("[time] readings_per_mean", printed)
        self.assertRegex(printed, r"noise 0\.005\d mm")  # 0.01 mm over the root of 3
        with open(self.folder / "out/deflection.csv", encoding="utf-8") as file:
            after = [row for row in csv.reader(file) if row[0] != "time_s"]
        self.assertAlmostEqual(float(after[1][0]) - float(after[0][0]), 3.0 / rate, delta=1e-8)
        fit = json.loads(self.culm("fit", "out", "--json", "-").stdout)["stems"][0]
        self.assertAlmostEqual(fit["b2_hz"]["value"], frequency, delta=0.1)
        self.write("mapping.toml", mapping.replace("[time]", "[time]\nreadings_per_mean = 1"))
        self.assertNotIn("averaged", self.imported("mapping.toml", "whole"))

    def test_31_a_zero_that_is_not_the_rest_is_named(self):
        self.folder_of("31-crash-offset")
        for command, code in (("calibrate", POINTS_FAILED), ("compare", BAD_INPUT),
                              ("diagnose", BAD_INPUT)):
            finished = self.culm(command, ".", "--spheres", "24")
            self.assert_exit(finished, code)
            said = finished.stdout + finished.stderr
            self.assertRegex(said, "FAILED: the stem swings about -20" if code == POINTS_FAILED
                             else "culm: T7: the stem swings about -20")
            self.assertIn("subtract the rest position", said)
            self.assertNotIn("next:", said)

    def test_31_a_bad_stem_does_not_hide_a_good_one(self):
        for folder in ("31-crash-offset", "19-round-rod-density"):
            shutil.copytree(FIELD / folder, self.folder / "stems" / folder)
        finished = self.culm("calibrate", "stems", "--spheres", "12")
        self.assert_exit(finished, POINTS_FAILED)
        self.assertRegex(finished.stdout, r"steel-rod +13\d\.\d ± ")
        self.assertRegex(finished.stdout, r"T7 +failed: the stem swings about")

    def test_a_time_zero_that_is_not_the_release_is_no_calibration(self):
        self.folder_of("19-round-rod-density")
        table = self.folder / "deflection.csv"
        head, *rows = table.read_text("utf-8").splitlines()
        for shift in (0.009, 0.3):
            late = [f"{float(row.split(',')[0]) + shift:.6f},{row.split(',', 1)[1]}" for row in rows]
            table.write_text("\n".join([head, *late]) + "\n", "utf-8")
            finished = self.culm("calibrate", ".", "--spheres", "12")
            self.assert_exit(finished, POINTS_FAILED)
            self.assertIn("FAILED", finished.stdout)
            self.assertIn("time 0 is not the release", finished.stdout)


class Videos(FieldFiles):
    def test_15_frames_of_unequal_duration_have_the_times_of_the_file(self):
        self.folder_of("15-vfr-video")
        finished = self.culm("track", "video.toml", "-o", "out")
        self.assert_exit(finished, DONE)
        self.assertIn("4.167 ms, and 5.208 ms from frame 76 on", finished.stdout)
        track = json.loads((self.folder / "out/track.json").read_text(encoding="utf-8"))
        self.assertAlmostEqual(track["swing_hz"], 20.0, delta=0.05)
        self.assertEqual(track["fps_source"], "of the file's time stamps")
        self.assertNotIn("fps", (self.folder / "out/stem.toml").read_text(encoding="utf-8"))
        finished = self.culm("setup", "phone.mov", "-o", "setup")
        self.assert_exit(finished, DONE)
        self.assertIn("12.0 frames per swing", finished.stdout)
        self.assertIn("240 frames/s at first, of the file's time stamps", finished.stdout)


class Machines(FieldFiles):
    def test_16_processes_that_each_work_alone_say_so(self):
        step = {**os.environ, "SLURM_STEP_ID": "0", "SLURM_NTASKS": "4", "SLURM_PROCID": "2"}
        self.write("study.toml", QUICK)
        for command in (("run", "study.toml", "-o", "out"), ("keys",)):
            finished = self.culm(*command, env=step)
            self.assert_exit(finished, DONE)
            self.assertEqual(finished.stderr.count("4 processes were started"), 1)
            self.assertIn("srun --mpi=pmix", finished.stderr)
        together = subprocess.run([*launcher(2), PROGRAM, "run", "study.toml", "-o", "two"],
                                  cwd=self.folder, env={**step, "SLURM_NTASKS": "2"}, text=True,
                                  capture_output=True, timeout=PATIENCE, check=False)
        self.assertNotIn("processes were started", together.stderr)

    def test_21_shares_in_a_part_of_the_design_say_so(self):
        self.folder_of("21-sobol-failed-points")
        finished = self.culm("run", "study.toml", "-o", "out")
        self.assertEqual(finished.returncode, POINTS_FAILED)
        self.assertIn("88 of 128 points failed", finished.stdout)
        summary = json.loads((self.folder / "out/summary.json").read_text("utf-8"))
        self.assertEqual(summary["variance_shares"]["frequency"]["points"], 40)
        self.assertEqual(summary["points"], 128)

    @unittest.skipUnless(shutil.which("cc"), "no C compiler")
    def test_26_a_file_system_without_locks_is_used_without_them(self):
        self.folder_of("26-no-locks")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", "nolock.so", "nolock.c", "-ldl"],
                       cwd=self.folder, check=True)
        environment = {**os.environ, "LD_PRELOAD": str(self.folder / "nolock.so")}
        self.write("study.toml", QUICK)
        self.assert_exit(self.culm("run", "study.toml", "-o", "locked"), DONE)
        finished = self.culm("run", "study.toml", "-o", "out", env=environment)
        self.assert_exit(finished, DONE)
        self.assertEqual(finished.stderr.count("has no locks"), 1)
        self.assert_exit(self.culm("archive", "verify", "out", env=environment), DONE)
        self.assertEqual(self.fits("out"), self.fits("locked"))


if __name__ == "__main__":
    sys.argv = sys.argv[:1]
    unittest.main()
