# SPDX-License-Identifier: BSD-3-Clause
"""`culm calibrate` and `culm export` on the command line."""

import csv
import json
import math
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PATIENCE, POINTS_FAILED, PROGRAM, QUICK, CulmTest, launcher

TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "support"))
from json_schema import schema_faults, schema_of  # noqa: E402

EXAMPLES = TESTS / "data" / "measurements"
SCHEMA = schema_of("calibration")
TRUE_MODULUS = 2.4e9  # of T1-null
# A chain of 20 spheres is quick; its Y is 0.3 % too high, its β that of 20 spheres.
QUICKLY = ("--spheres", "20", "--window", "0.15")


class Calibrate(CulmTest):
    def calibrate(self, *arguments, code=DONE):
        finished = self.culm("calibrate", *arguments, "--json", "calibration.json")
        self.assert_exit(finished, code)
        result = json.loads((self.folder / "calibration.json").read_text("utf-8"))
        self.assertEqual(schema_faults(result, SCHEMA), [])
        return finished, result

    def damaged(self) -> Path:
        """A folder that contains a good stem and one that does not vibrate."""
        folder = self.folder / "stems"
        shutil.copytree(EXAMPLES / "T1-null", folder / "good")
        shutil.copytree(EXAMPLES / "T1-null", folder / "still")
        file = folder / "still" / "deflection.csv"
        lines = file.read_text("utf-8").splitlines()
        still = [",".join([line.split(",")[0]] + ["0"] * line.count(",")) for line in lines[1:]]
        file.write_text("\n".join([lines[0], *still]) + "\n", "utf-8")
        return folder

    def test_recovers_the_null_stem(self):
        finished, result = self.calibrate(str(EXAMPLES / "T1-null"))
        stem = result["stems"][0]
        modulus = stem["parameters"]["bond_youngs_modulus_pa"]
        self.assertAlmostEqual(modulus["value"] / TRUE_MODULUS, 1, delta=0.002)
        self.assertTrue(stem["fit"]["adequate"])
        self.assertEqual(stem["fit"]["failed_tests"], [])
        self.assertRegex(stem["sentence"], r"^T1: Y = 2\.(39|40).* GPa, beta = 1.*No model deficiency")
        self.assertIsNone(result["population"])
        self.assertIn("No model deficiency detectable in this recording.", finished.stdout)

    def test_fits_the_effects_of_a_rig_to_all_its_stems(self):
        drag = TESTS / "data" / "hidden-effect" / "T2-quadratic_drag"
        for name in ("A", "B"):
            self.copy_recording(drag, name, name, 'rig = "1"')
        finished, together = self.calibrate("A", "B", "--with", "quadratic_drag", *QUICKLY, "-q")
        self.assertRegex(finished.stdout, r"^  quadratic_drag of rig 1, known\n"
                         r"    quadratic_drag.drag_coefficient +1\.\d+  \(95 %: ")
        effect = together["shared_effects"][0]
        shared = effect["parameters"][0]
        self.assertEqual((effect["rig"], shared["name"]), ("1", "drag_coefficient"))
        alone = self.calibrate("A", "B", "--with", "quadratic_drag", "--each-alone", *QUICKLY,
                               "-q")[1]
        self.assertEqual(alone["shared_effects"], [])
        of_one = alone["stems"][0]["parameters"]["quadratic_drag.drag_coefficient"]
        # The two recordings are the same: the same value with 1/sqrt(2) of the uncertainty that
        # comes from the readings.
        self.assertAlmostEqual(shared["value"], of_one["value"], delta=0.02 * of_one["value"])
        width = (shared["interval_95"][1] - shared["interval_95"][0]) / (2 * 1.96)
        self.assertLess(width, of_one["stderr"])
        stem = together["stems"][0]
        self.assertNotIn("quadratic_drag.drag_coefficient", stem["parameters"])
        line = stem["uncertainty_budget"]["inputs"][-1]
        self.assertEqual(line["name"], "effects shared by rig 1")
        self.assertGreater(line["shares"]["bond_damping"], 0.005)

    def test_states_the_residual_with_every_input_as_stated(self):
        clamp = TESTS / "data" / "hidden-effect" / "T3-clamp_compliance"
        fit = self.calibrate(str(clamp), *QUICKLY)[1]["stems"][0]["fit"]
        self.assertAlmostEqual(fit["rmse_over_noise"], fit["rmse_mm"] / fit["noise_mm"], delta=0.01)
        self.assertGreater(fit["rmse_over_noise"], 3)  # it is 1 with the clamp moved by 9 mm
        self.assertIn("clamp height", "".join(each["name"] for each in fit["contradicted_inputs"]))

    def test_knows_a_stem_as_well_as_its_inputs(self):
        by_default, plain = self.calibrate(str(EXAMPLES / "T1-null"), *QUICKLY)
        self.assertIn("No uncertainty is stated for length, diameter, density, scale, clamp "
                      "height: the defaults are used.", " ".join(by_default.stdout.split()))
        self.assertLessEqual(len(by_default.stdout.splitlines()), 25)
        self.assertLessEqual(max(map(len, by_default.stdout.splitlines())), 100)
        self.assertRegex(by_default.stdout, r"Uncertainty of bond_youngs_modulus: diameter \d+ %")
        shutil.copytree(EXAMPLES / "T1-null", self.folder / "measured")
        stem = self.folder / "measured" / "stem.toml"
        text = stem.read_text("utf-8")
        stem.write_text(re.sub(r"(?m)^(diameter_mm.*)$", r"\1\ndiameter_uncertainty_mm = 0.001", text),
                        "utf-8")
        finished, better = self.calibrate("measured", "--details", *QUICKLY)
        key = "bond_youngs_modulus_pa"

        def shares(result):
            stem = result["stems"][0]
            budget = stem["uncertainty_budget"]
            parts = {entry["name"]: entry["shares"][key] for entry in budget["inputs"]}
            parts["readings"] = budget["readings"]["shares"][key]
            self.assertAlmostEqual(sum(parts.values()), 1.0, places=6)
            self.assertEqual(stem["parameters"][key]["stderr"], budget["combined"][key])
            return parts, stem["parameters"][key], budget["readings"]["standard_uncertainties"][key]

        before, wide, wide_readings = shares(plain)
        after, narrow, narrow_readings = shares(better)
        self.assertGreater(before["diameter"], 0.5)
        self.assertLess(after["diameter"], 0.01)
        # Y is the same, because the readings determine the diameter only through the scale; its
        # interval was that of the calipers.
        self.assertAlmostEqual(wide["value"] / narrow["value"], 1.0, places=4)
        self.assertAlmostEqual(wide_readings / narrow_readings, 1.0, delta=0.02)
        self.assertLess(narrow["stderr"], 0.6 * wide["stderr"])
        self.assertIn("0.001 mm  ", finished.stdout)
        self.assertNotIn("stated for length, diameter", finished.stdout)

    def test_summarises_a_population_with_a_failure(self):
        finished, result = self.calibrate(str(EXAMPLES), str(self.damaged() / "still"), *QUICKLY,
                                          code=POINTS_FAILED)
        self.assertEqual(len(result["stems"]), 4)
        self.assertIn("failure", result["stems"][3])
        self.assertEqual(result["population"]["stems"], 3)
        self.assertEqual(result["population"]["failed"], 1)
        self.assertIn("90 % of the stems lie in", finished.stdout)
        self.assertIn("failed:", finished.stdout)

    def test_gives_the_same_result_on_two_ranks(self):
        folder = str(self.damaged())
        _, alone = self.calibrate(folder, *QUICKLY, code=POINTS_FAILED)
        together = subprocess.run(
            [*launcher(2), PROGRAM, "calibrate", folder, *QUICKLY, "--json", "two.json"],
            cwd=self.folder, text=True, capture_output=True, timeout=PATIENCE, check=False)
        self.assertEqual(together.returncode, POINTS_FAILED, together.stderr)
        shared = json.loads((self.folder / "two.json").read_text("utf-8"))
        self.assertEqual((alone.pop("provenance")["ranks"], shared.pop("provenance")["ranks"]),
                         (1, 2))
        self.assertEqual(shared, alone)

    def test_writes_predictions_with_the_readings(self):
        self.calibrate(str(EXAMPLES / "T1-null"), *QUICKLY, "-o", "out")
        with (self.folder / "out" / "predictions" / "001.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        first = rows[0]
        # The noise is 0.05 mm: five standard deviations.
        self.assertAlmostEqual(float(first["measured h=148mm"]),
                               float(first["predicted h=148mm"]), delta=0.25)
        self.assertTrue((self.folder / "out" / "calibration.json").is_file())

    def test_fits_the_raw_acceleration_of_a_metal_strip(self):
        strip = TESTS / "data" / "aluminium-strip"
        finished, result = self.calibrate(strip, "--spheres", "20", "--with", "quadratic_drag")
        self.assertIn("m/s² rms", finished.stdout)
        self.assertNotIn(" mm rms", finished.stdout)
        self.assertIn('the centre of column "acc_g"', finished.stderr)
        stem = result["stems"][0]
        # Known from the zero crossings of the whole record: 16.38 Hz, 0.3 % less at large amplitude.
        frequency = float(re.search(r"first mode: b2 ([0-9.]+)", finished.stdout).group(1))
        self.assertAlmostEqual(frequency, 16.35, delta=0.05)
        # The nominal modulus of aluminium is 70 GPa; a vice that yields a little lowers it.
        modulus = stem["parameters"]["bond_youngs_modulus_pa"]["value"]
        self.assertTrue(60e9 < modulus < 72e9, modulus)

    def test_warns_of_a_study_of_another_stem(self):
        self.write("study.toml", QUICK)
        self.assert_exit(self.culm("run", "study.toml", "-o", "study", "-q"), DONE)
        finished, result = self.calibrate(str(EXAMPLES / "T1-null"), *QUICKLY, "--via", "study")
        via = result["stems"][0]["via"]
        self.assertIsNotNone(via["bond_youngs_modulus_pa"]["single_law"])
        self.assertIn("WARNING", finished.stdout)
        self.assertTrue(any("ANOTHER STEM" in warning for warning in via["warnings"]))

    def test_refuses_an_unknown_effect_with_the_nearest_name(self):
        finished = self.culm("calibrate", str(EXAMPLES / "T1-null"), "--with", "quadratic_dragg")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("quadratic_drag", finished.stderr)

    def test_refuses_a_missing_folder(self):
        finished = self.culm("calibrate", "nowhere")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("nowhere", finished.stderr)


class HeldStraight(CulmTest):
    def test_does_not_move_without_gravity(self):
        shutil.copytree(EXAMPLES / "T1-null", self.folder / "held")
        with open(self.folder / "held" / "stem.toml", "a", encoding="utf-8") as file:
            file.write('[release]\nkind = "held_straight"\n')
        finished = self.culm("calibrate", "held")
        self.assert_exit(finished, POINTS_FAILED)
        self.assertIn("add --with gravity", finished.stdout)


class Export(CulmTest):
    def calibrated(self, law: str) -> str:
        self.assert_exit(self.culm("calibrate", str(EXAMPLES / "T1-null"), *QUICKLY, "--law", law,
                                   "--json", f"{law}.json"), DONE)
        return f"{law}.json"

    def test_writes_liggghts_lines_with_the_calibrated_values(self):
        file = self.calibrated("schramm2019")
        finished = self.culm("export", "liggghts", file)
        self.assert_exit(finished, DONE)
        stem = json.loads((self.folder / file).read_text("utf-8"))["stems"][0]
        words = next(line.split() for line in finished.stdout.splitlines()
                     if line.startswith("bond_coeff"))
        # Type, outer, inner, Y, G, damping type, beta, breakage type, two limits.
        self.assertEqual(len(words), 11)
        # The values of this chain, with every input as stated.
        for word, key in ((4, "bond_youngs_modulus_pa"), (7, "bond_damping")):
            of_chain = stem["chain"][key]
            self.assertAlmostEqual(float(words[word]) / of_chain, 1, places=7)
            found = stem["parameters"][key]
            self.assertLess(abs(of_chain - found["value"]), found["stderr"])
        self.assertIn("law schramm2019, SI units", finished.stdout)

    def test_refuses_the_wrong_law(self):
        file = self.calibrated("consistent")
        finished = self.culm("export", "liggghts", file)
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("--law schramm2019", finished.stderr)
        self.assert_exit(self.culm("export", "lammps", file, "-o", "stem.lmp"), DONE)
        self.assertIn("bond_style bpm/rotational",
                      (self.folder / "stem.lmp").read_text("utf-8"))

    def test_includes_known_masses_and_effects(self):
        shutil.copytree(EXAMPLES / "T1-null", self.folder / "stem")
        with open(self.folder / "stem" / "stem.toml", "a", encoding="utf-8") as file:
            file.write("\n[[added_mass]]\nheight_mm = 157.0\nmass_g = 0.002\n")
        self.assert_exit(self.culm("calibrate", "stem", *QUICKLY, "--with", "viscous_drag",
                                   "--json", "mass.json"), DONE)
        document = json.loads((self.folder / "mass.json").read_text("utf-8"))
        self.assertEqual(schema_faults(document, SCHEMA), [])
        chain = document["stems"][0]["chain"]
        self.assertEqual(chain["added_masses"], [{"height_m": 0.157, "mass_kg": 2e-6}])

        refused = self.culm("export", "lammps", "mass.json")
        self.assert_exit(refused, BAD_INPUT)
        self.assertIn("--without viscous_drag", refused.stderr)
        self.assertEqual(refused.stdout, "")
        finished = self.culm("export", "lammps", "mass.json", "--without", "viscous_drag")
        self.assert_exit(finished, DONE)
        self.assertIn("calibrated with viscous_drag, which --without left out", finished.stdout)
        density = next(float(line.split()[-1]) for line in finished.stdout.splitlines()
                       if line.startswith("set atom 20 density"))
        volume = math.pi / 6 * chain["sphere_diameter_m"] ** 3
        own = chain["tip_mass_share"] * chain["sphere_density_kg_m3"]
        self.assertAlmostEqual(density / (own + 2e-6 / volume), 1, places=7)

    def test_refuses_a_calibration_without_added_masses(self):
        file = self.calibrated("consistent")
        document = json.loads((self.folder / file).read_text("utf-8"))
        del document["stems"][0]["chain"]["added_masses"]
        self.write("old.json", json.dumps(document))
        finished = self.culm("export", "lammps", "old.json")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("calibrate the stem again", finished.stderr)

    def test_refuses_another_file(self):
        self.write("fit.json", '{"format": "culm-fit"}')
        finished = self.culm("export", "lammps", "fit.json")
        self.assert_exit(finished, BAD_INPUT)
        self.assertIn("fit.json", finished.stderr)


if __name__ == "__main__":
    unittest.main()
