# SPDX-License-Identifier: BSD-3-Clause
"""culm run --from-archive: the archive alone repeats its study, and differences are reported."""

import json
import sys
import unittest
from pathlib import Path

from culm_program import (BAD_INPUT, DONE, OVERDAMPED, PATIENCE, POINTS_FAILED, PROGRAM, QUICK,
                          CulmTest, launcher)

SOURCE = Path(__file__).resolve().parents[2]
sys.path.append(str(SOURCE / "tests" / "support"))
from json_schema import schema_faults  # noqa: E402

try:
    import h5py
except ImportError:
    h5py = None

SCHEMA = json.loads((SOURCE / "docs/schemas/repetition.schema.json").read_text(encoding="utf-8"))

EFFECT = """
[effect]
name = "my_drag"
kind = "force_per_length"
expression = "-c*v*abs(v)"
[parameters.c]
default = 0.002
lower = 0
upper = 1
unit = "N s2/m3"
"""

WITH_EFFECT = '[study]\nname = "kept"\nstore = "full"\neffects = ["law/my_drag.toml"]\n' + QUICK


class Repetition(CulmTest):
    def setUp(self):
        super().setUp()
        (self.folder / "there" / "law").mkdir(parents=True)
        self.write("there/s.toml", WITH_EFFECT)
        self.write("there/law/my_drag.toml", EFFECT)

    def archived(self):
        """A study whose files were removed; only its archive exists."""
        self.assert_exit(self.culm("run", "there/s.toml", "-o", "out", "-q"), DONE)
        for file in ("s.toml", "law/my_drag.toml"):
            (self.folder / "there" / file).unlink()

    def told(self, folder: str) -> dict:
        found = json.loads((self.folder / folder / "repetition.json").read_text(encoding="utf-8"))
        self.assertEqual(schema_faults(found, SCHEMA), [])
        return found

    def test_is_identical_bit_for_bit_from_the_archive_alone(self):
        self.archived()
        again = self.culm("run", "--from-archive", "out", "-o", "again", "-q")
        self.assert_exit(again, DONE)
        self.assertRegex(again.stdout, r"\nidentical  bit for bit: 9 points, \d+ columns and "
                                       r"histories\n\nnext: culm report again\n$")
        found = self.told("again")
        self.assertTrue(found["is_identical"])
        self.assertEqual(found["points"], 9)
        self.assertEqual(found["facts"]["version"]["archived"], found["facts"]["version"]["now"])
        self.assertEqual(self.fits("again"), self.fits("out"))
        # A repeated study can be repeated again.
        third = self.culm("run", "--from-archive", "again", "-q")
        self.assert_exit(third, DONE)
        self.assertTrue(self.told("results/kept-repeated")["is_identical"])

    def test_is_identical_on_two_ranks(self):
        self.archived()
        process = self.start(*launcher(2), PROGRAM, "run", "--from-archive", "out", "-o", "again", "-q")
        output, errors = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, DONE, errors)
        self.assertEqual(output.count("identical  bit for bit"), 1)
        self.assertEqual(self.told("again")["facts"]["ranks"], {"archived": "1", "now": "2"})

    def test_other_commands_need_only_the_archive(self):
        self.archived()
        self.assert_exit(self.culm("reduce", "out", "--keep"), DONE)
        self.assert_exit(self.culm("archive", "merge", "out", "-o", "merged"), DONE)
        self.assert_exit(self.culm("reduce", "merged", "--keep"), DONE)
        self.assert_exit(self.culm("run", "--from-archive", "merged", "-o", "again", "-q"), DONE)

    @unittest.skipIf(h5py is None, "h5py is missing: no archive can be altered")
    def test_reports_what_differs_and_by_how_much(self):
        self.archived()
        with h5py.File(self.folder / "out/study.h5", "r+") as file:  # its checksums follow
            frequency = file["results/frequency"]
            frequency[4] *= 1 + 1e-6
            file["particles/point_000002/position/value"][3, 4, 1] += 1e-9
            expected = float(frequency[4]) * 1e-6
            file["provenance"].attrs["compiler"] = "another one"
        again = self.culm("run", "--from-archive", "out", "-o", "again", "-q")
        self.assert_exit(again, POINTS_FAILED)
        self.assertRegex(again.stdout, r"compiler +another one \(archived\)\n +g\+\+ .* \(now\)\n")
        self.assertRegex(again.stdout, r"\ndiffers    results/frequency: 1 of 9 points, by at most "
                                       r"\S+ Hz \(relative 1e-06\), first at point 4\n")
        found = self.told("again")
        self.assertFalse(found["is_identical"])
        by_name = {entry["dataset"]: entry for entry in found["differing"]}
        self.assertEqual(set(by_name), {"results/frequency", "particles"})
        # The limits allow for the rounding of the product above.
        self.assertAlmostEqual(by_name["results/frequency"]["largest"], expected, delta=1e-9)
        self.assertEqual(by_name["results/frequency"]["first_point"], 4)
        self.assertEqual(by_name["particles"]["first_point"], 2)

    def test_failed_points_fail_again(self):
        self.write("failing.toml", OVERDAMPED)
        self.assert_exit(self.culm("run", "failing.toml", "-o", "out", "-q"), POINTS_FAILED)
        again = self.culm("run", "--from-archive", "out", "-o", "again", "-q")
        self.assert_exit(again, POINTS_FAILED)
        self.assertTrue(self.told("again")["is_identical"])

    def test_refuses_wrong_options_and_folders(self):
        self.archived()
        self.assert_refused(self.culm("run"), "culm: give a study file or --from-archive DIR, one "
                                              "of the two\n")
        self.assert_refused(self.culm("run", "s.toml", "--from-archive", "out"),
                            "culm: give a study file or --from-archive DIR, one of the two\n")
        self.assert_refused(self.culm("run", "--from-archive", "out", "-o", "./out"),
                            "culm: ./out is the archive's own folder; choose another one with "
                            "-o\n")
        self.assert_refused(self.culm("run", "--from-archive", "there"),
                            "culm: there: there is no study here (study.h5 is missing)\n")
        archive = self.folder / "out/study.h5"
        content = bytearray(archive.read_bytes())
        content[len(content) // 2] ^= 4
        archive.write_bytes(content)
        damaged = self.culm("run", "--from-archive", "out", "-o", "again")
        self.assert_exit(damaged, BAD_INPUT)
        self.assertIn("damaged", damaged.stderr)
        self.assertFalse((self.folder / "again").exists())


if __name__ == "__main__":
    unittest.main()
