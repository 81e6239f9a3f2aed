# SPDX-License-Identifier: BSD-3-Clause
"""The reader returns the content of the file, or reports what is wrong with it."""
import importlib.util
import os
import subprocess
import tempfile
import unittest
import unittest.mock
from pathlib import Path

import h5py
import numpy as np
from culm.archive import Study, StudyError
from synthetic_study import DURATION, HEIGHTS, SAMPLES, SPHERES, Synthetic


class StudyIsRead(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.truth = Synthetic()
        cls.study = Study(cls.truth.write(cls.folder.name))

    @classmethod
    def tearDownClass(cls):
        cls.study.close()
        cls.folder.cleanup()

    def test_factors_are_columns_in_config_units(self):
        self.assertEqual(self.study.factor_names, ["bond_damping", "bond_youngs_modulus_gpa"])
        self.assertEqual(self.study.unit("bond_youngs_modulus_gpa"), "GPa")
        np.testing.assert_array_equal(self.study["bond_damping"], self.truth.damping)
        np.testing.assert_array_equal(
            self.study.factors["bond_youngs_modulus_gpa"], self.truth.modulus_gpa
        )

    def test_results_are_columns_with_nan_where_there_is_no_answer(self):
        frequency = self.study["frequency"]
        done = self.truth.is_completed
        np.testing.assert_array_equal(frequency[done], self.truth.frequency[done])
        self.assertTrue(np.isnan(frequency[~done]).all())
        self.assertEqual(list(self.study.results), self.study.result_names)
        self.assertEqual(self.study.unit("decay_rate_standard_error"), "1/s")
        self.assertEqual(self.study.description("steps"), "the steps")
        self.assertIn("r_squared", self.study)
        self.assertNotIn("nothing", self.study)

    def test_every_point_has_a_status_and_failures_have_a_reason(self):
        self.assertEqual(self.study.points, 12)
        self.assertEqual(self.study.statuses[4], "failed")
        self.assertEqual(self.study.statuses[9], "missing")
        np.testing.assert_array_equal(self.study.is_completed, self.truth.is_completed)
        self.assertEqual(self.study.failures, [(4, "not_a_number", "NaN at 1 µs, β")])

    def test_histories_have_the_documented_shapes_and_values(self):
        self.assertEqual(self.study.time.shape, (SAMPLES,))
        np.testing.assert_array_equal(self.study.heights, HEIGHTS)
        np.testing.assert_array_equal(self.study.tip_deflection(5), self.truth.tip(5))
        np.testing.assert_array_equal(
            self.study.height_deflection(5), self.truth.height_deflection(5)
        )
        positions = self.study.positions(5)
        self.assertEqual(positions.shape, (SAMPLES, SPHERES, 3))
        np.testing.assert_array_equal(positions, self.truth.positions(5))
        self.assertEqual(self.study.spheres, SPHERES)

    def test_all_of_it_is_one_table_with_or_without_pandas(self):
        without = {"pandas": None}  # makes its import fail
        with unittest.mock.patch.dict("sys.modules", without):
            table = self.study.table()
        names = ["status", *self.study.factor_names, *self.study.result_names]
        self.assertEqual(list(table), names)
        np.testing.assert_array_equal(table["frequency"], self.study["frequency"])
        if importlib.util.find_spec("pandas") is None:
            self.skipTest("pandas is not installed; the rest was tested")
        frame = self.study.table()
        self.assertEqual(list(frame.columns), names)
        self.assertEqual(frame.index.name, "point")
        self.assertEqual(frame.loc[4, "status"], "failed")
        self.assertEqual(frame.attrs["units"]["frequency"], "Hz")
        np.testing.assert_array_equal(frame["frequency"], self.study["frequency"])

    def test_a_constant_parameter_is_repeated_for_every_point(self):
        np.testing.assert_array_equal(self.study.parameter("density_kg_m3"), np.full(12, 125.0))
        np.testing.assert_array_equal(self.study.parameter("bond_damping"), self.truth.damping)
        with self.assertRaisesRegex(StudyError, "no number for 'wall'"):
            self.study.parameter("wall")

    def test_provenance_and_settings_are_text(self):
        expected = {"compiler": "GNU 12.2", "config": "[factors]\n# β\n"}
        self.assertEqual(self.study.provenance, expected)
        self.assertEqual(self.study.settings["reduce.window_s"], str(DURATION))
        self.assertEqual(self.study.summary["completed"], 10)

    def test_the_representation_counts_the_points(self):
        self.assertIn("10 of 12 points completed", repr(self.study))

    def test_an_unknown_column_names_the_nearest_one(self):
        with self.assertRaisesRegex(StudyError, "'frequenzy'; the nearest is 'frequency'"):
            self.study["frequenzy"]

    def test_points_without_history_are_refused(self):
        with self.assertRaisesRegex(StudyError, "point 4 has no history: it is failed"):
            self.study.tip_deflection(4)
        with self.assertRaisesRegex(StudyError, "point 9 has no history: it is missing"):
            self.study.positions(9)
        with self.assertRaisesRegex(StudyError, "point 12 is not one of 0 … 11"):
            self.study.tip_deflection(12)


class BrokenFilesAreRefused(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.path = self.folder / "study.h5"

    def write(self, **options):
        return Synthetic(**options).write(self.folder)

    def assert_refused(self, pattern):
        with self.assertRaisesRegex(StudyError, pattern):
            Study(self.folder).close()

    def test_a_folder_without_an_archive_is_refused(self):
        self.assert_refused("study.h5 does not exist")

    def test_a_folder_that_does_not_exist_is_refused(self):
        with self.assertRaisesRegex(StudyError, "nowhere is not a folder"):
            Study(self.folder / "nowhere")

    def test_a_file_that_is_not_hdf5_is_refused(self):
        self.path.write_text("a text")
        self.assert_refused("not a readable HDF5 file")

    def test_an_hdf5_file_of_another_format_is_refused(self):
        with h5py.File(self.path, "w") as file:
            file.attrs["format"] = "netcdf"
        self.assert_refused("states the format 'netcdf', not 'culm-study'")

    def test_another_major_version_is_refused_but_not_another_minor_one(self):
        self.write()
        with h5py.File(self.path, "r+") as file:
            file.attrs["format_version"] = "2.0"
        self.assert_refused("version '2.0'; this reader knows 1.x")
        with h5py.File(self.path, "r+") as file:
            file.attrs["format_version"] = "1.7"
        Study(self.folder).close()

    def test_a_flipped_byte_in_a_column_is_refused(self):
        self.write()
        with h5py.File(self.path) as file:
            start = file["results/frequency"].id.get_chunk_info(0).byte_offset
        content = bytearray(self.path.read_bytes())
        content[start + 5] ^= 0xFF
        self.path.write_bytes(content)
        with Study(self.folder) as study:
            with self.assertRaisesRegex(StudyError, "/results/frequency is damaged"):
                study["frequency"]

    def test_an_absent_chunk_is_damage_and_not_nan(self):
        self.write()
        with h5py.File(self.path, "r+") as file:
            del file["results/frequency"]
            column = file["results"].create_dataset(
                "frequency", (12,), "f8", chunks=(6,), fletcher32=True, fillvalue=np.nan
            )
            column[:6] = 1.0
        with Study(self.folder) as study:
            with self.assertRaisesRegex(StudyError, "/results/frequency is damaged: chunks"):
                study["frequency"]

    def test_a_text_that_does_not_match_its_checksum_is_refused(self):
        self.write()
        with h5py.File(self.path, "r+") as file:
            file["provenance/identity"].attrs["crc32"] = 1
        with Study(self.folder) as study:
            with self.assertRaisesRegex(StudyError, "/provenance/identity is damaged"):
                study.settings

    def test_histories_that_are_not_stored_are_refused(self):
        with Study(self.write(store="fit")) as study:
            self.assertFalse(study.stores_tip)
            with self.assertRaisesRegex(StudyError, "does not store tip deflection"):
                study.tip_deflection(0)
            with self.assertRaisesRegex(StudyError, "does not store positions"):
                study.positions(0)

    def test_a_summary_that_is_absent_or_not_json_is_refused(self):
        self.write()
        summary = self.folder / "summary.json"
        with Study(self.folder) as study:
            for content in ("{", "[]"):
                summary.write_text(content)
                with self.assertRaisesRegex(StudyError, "summary.json"):
                    study.summary
            summary.unlink()
            with self.assertRaisesRegex(StudyError, "does not exist; 'culm reduce' writes it"):
                study.summary


WRITE_EXAMPLE = os.environ.get("CULM_WRITE_EXAMPLE_STUDY", "")


@unittest.skipUnless(os.path.exists(WRITE_EXAMPLE), "the archive's example program is not built")
class TheArchivesOwnExampleIsRead(unittest.TestCase):
    def test_tables_histories_and_texts_are_as_documented(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([WRITE_EXAMPLE, os.path.join(folder, "study.h5")], check=True)
            with Study(folder) as study:
                expected = ["completed"] * 2 + ["failed", "completed", "missing", "completed"]
                self.assertEqual(study.statuses.tolist(), expected)
                self.assertEqual(study.factor_names, ["bond_youngs_modulus", "bond_damping"])
                self.assertEqual(study["bond_youngs_modulus"][1], 2e9)
                self.assertEqual(study.unit("bond_youngs_modulus"), "Pa")
                self.assertEqual(np.isnan(study["frequency"]).nonzero()[0].tolist(), [2, 4])
                self.assertTrue(study.failures[0].reason.endswith("(β = 200)"))
                samples, heights = study.time.size, study.heights.size
                self.assertEqual(study.tip_deflection(3).shape, (samples,))
                self.assertEqual(study.height_deflection(3).shape, (samples, heights))
                self.assertEqual(study.positions(3).shape, (samples, study.spheres, 3))
                self.assertTrue(study.provenance["config"].endswith("\nβ = [1, 2]\n"))


if __name__ == "__main__":
    unittest.main()
