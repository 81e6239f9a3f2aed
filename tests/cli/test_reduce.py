# SPDX-License-Identifier: BSD-3-Clause
"""culm reduce: other windows, fixed amplitude, JSON; an archive that is damaged."""

import csv
import json
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, OVERDAMPED, POINTS_FAILED, QUICK, CulmTest


CONFIG = Path(__file__).resolve().parents[2] / "config"


class PublishedStudy(CulmTest):
    def test_has_its_slopes(self):
        self.assert_exit(self.culm("run", CONFIG / "schramm2019.toml", "-o", "out", "-q"), DONE)
        (self.folder / "out/summary.json").unlink()
        self.assert_exit(self.culm("reduce", "out"), DONE)
        laws = json.loads((self.folder / "out/summary.json").read_text("utf-8"))["regression"]
        for law, slope in (("sqrt_youngs_modulus", 574.31), ("bond_damping", -261.73)):
            self.assertAlmostEqual(laws[law]["slope"] / slope, 1.0, delta=5e-4)


class Reduce(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        self.summary = self.read_summary()

    def read_summary(self) -> dict:
        return json.loads((self.folder / "out/summary.json").read_text(encoding="utf-8"))

    def frequencies(self) -> list[float]:
        with open(self.folder / "out/fits.csv", encoding="utf-8", newline="") as file:
            return [float(row["frequency_hz"]) for row in csv.DictReader(file)]

    def test_gives_the_summary_of_the_run_without_options(self):
        before = self.frequencies()
        self.assert_exit(self.culm("reduce", "out"), DONE)
        self.assertEqual(self.read_summary(), self.summary)
        self.assertEqual(self.frequencies(), before)

    def test_window_fits_the_beginning_of_the_histories(self):
        before = self.frequencies()
        finished = self.culm("reduce", "out", "--window", "0.03")
        self.assert_exit(finished, DONE)
        self.assertEqual(finished.stdout.splitlines()[0],
                         "Eq. 1 fitted to the tip over 0.03 s, b0 free; b1 per cycle, b2 in "
                         "Hz; law schramm2019")
        self.assertEqual(self.read_summary()["fit"]["window_s"], 0.03)
        for new, old in zip(self.frequencies(), before):
            self.assertNotEqual(new, old)
            self.assertAlmostEqual(new / old, 1, delta=0.03)

    def test_amplitude_can_be_fixed_at_the_initial_deflection(self):
        before = self.frequencies()
        finished = self.culm("reduce", "out", "--amplitude", "fixed")
        self.assert_exit(finished, DONE)
        self.assertEqual(finished.stdout.splitlines()[0],
                         "Eq. 1 fitted to the tip over the whole record, b0 fixed; b1 per cycle, "
                         "b2 in Hz; law schramm2019")
        self.assertEqual(self.read_summary()["fit"]["amplitude"], "fixed")
        self.assertNotEqual(self.frequencies(), before)

    def test_significance_decides_which_terms_stay(self):
        self.assert_exit(self.culm("reduce", "out", "--significance", "1e-6"), DONE)
        found = self.read_summary()
        self.assertEqual(found["fit"]["significance"], 1e-6)
        terms = [len(summary["regression"]["sqrt_youngs_modulus"]["terms"])
                 for summary in (found, self.summary)]
        self.assertLess(terms[0], terms[1])

    def test_does_not_change_the_files_with_keep(self):
        finished = self.culm("reduce", "out", "--window", "0.03", "--keep", "--json", "other.json")
        self.assert_exit(finished, DONE)
        self.assertEqual(self.read_summary(), self.summary)
        other = json.loads((self.folder / "other.json").read_text(encoding="utf-8"))
        self.assertEqual(other["fit"]["window_s"], 0.03)

    def test_json_on_standard_output_is_all_that_is_printed(self):
        finished = self.culm("reduce", "out", "--json", "-")
        self.assert_exit(finished, DONE)
        self.assertEqual(json.loads(finished.stdout), self.summary)

    def test_window_beyond_the_record_is_refused(self):
        for window in ("0.06", "0", "-1", "nan"):
            self.assert_refused(
                self.culm("reduce", "out", f"--window={window}"),
                f"culm: --window {window}: must be above 0 and at most 0.05 s, the study's "
                "duration\n")

    def test_unknown_amplitude_is_refused(self):
        self.assert_refused(self.culm("reduce", "out", "--amplitude", "loose"),
                            "culm reduce: --amplitude: loose not in {free,fixed}\n"
                            "Try `culm reduce --help`.\n")

    def test_file_that_cannot_be_written_is_named(self):
        finished = self.culm("reduce", "out", "--keep", "--json", "no/such.json")
        self.assert_exit(finished, BAD_INPUT)
        self.assertEqual(finished.stderr, "culm: no/such.json: cannot be written\n")

    def test_damaged_archive_is_named_and_never_read_as_numbers(self):
        archive = self.folder / "out/study.h5"
        content = bytearray(archive.read_bytes())
        middle = len(content) // 2
        content[middle:middle + 2000] = bytes(2000)
        archive.write_bytes(content)
        finished = self.culm("reduce", "out", "--keep")
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"^culm: out/study\.h5: cannot read /histories/tip_")
        self.assertEqual(finished.stdout, "")

    def test_truncated_archive_is_named_and_the_study_can_be_moved_away(self):
        archive = self.folder / "out/study.h5"
        archive.write_bytes(archive.read_bytes()[:1000])
        finished = self.culm("run", "s.toml", "-o", "out", "--resume")
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"^culm: out/study\.h5: cannot open it as an HDF5 file: "
                                          r"truncated file.*\nMove this file away to compute the "
                                          r"study again, or choose another folder with -o\.\n$")
        archive.rename(self.folder / "out/old.h5")
        self.assert_exit(self.culm("run", "s.toml", "-o", "out"), DONE)


class ReduceFailed(CulmTest):
    def test_lists_the_points_without_a_fit_again(self):
        self.write("s.toml", OVERDAMPED)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), POINTS_FAILED)
        finished = self.culm("reduce", "out")
        self.assert_exit(finished, POINTS_FAILED)
        self.assertIn("3 of 9 points failed:", finished.stdout)

    def test_study_that_stores_fits_only_cannot_be_fitted_again(self):
        self.write("s.toml", '[study]\nstore = "fit"\n' + QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        self.assert_exit(self.culm("reduce", "out"), DONE)
        self.assert_refused(
            self.culm("reduce", "out", "--window", "0.03"),
            'culm: out/study.h5: the study stores no tip histories (study.store = "fit"), so they '
            "cannot be fitted again\n")


if __name__ == "__main__":
    unittest.main()
