# SPDX-License-Identifier: BSD-3-Clause
"""culm archive for programs and for older studies: JSON schema, older formats, missing data, and
other readers."""

import csv
import importlib.util
import json
import math
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from culm_program import (BAD_INPUT, DONE, OVERDAMPED, PATIENCE, POINTS_FAILED, PROGRAM, QUICK,
                          SLOW, STOPPED_EARLY, CulmTest, launcher)

SOURCE = Path(__file__).resolve().parents[2]
OLDER = SOURCE / "tests" / "data" / "older-formats"
sys.path += [str(SOURCE / "tests" / "support"), str(SOURCE / "postprocess")]
from culm.archive import Study  # noqa: E402
from json_schema import schema_faults, schema_of  # noqa: E402

SCHEMA = schema_of("archive")
HAS_H5PY = importlib.util.find_spec("h5py") is not None

FULL = '[study]\nstore = "full"\nheights_mm = [60, 120]\n' + QUICK


BOUNDED = """
[effect]
name = "bounded"
kind = "force_per_length"
expression = "-1e-4 * v * sqrt(vmax - abs(v))"
[parameters.vmax]
default = 5
lower = 2
upper = 10
"""


class ArchiveTest(CulmTest):
    def told(self, command: str, folder: str) -> dict:
        """The JSON of info, status or verify, validated by the schema."""
        finished = self.culm("archive", command, folder, "--json", "-")
        self.assertIn(finished.returncode, (DONE, POINTS_FAILED), finished.stderr)
        found = json.loads(finished.stdout)
        self.assertEqual(schema_faults(found, SCHEMA), [], command)
        return found

    def interrupted(self, text: str = SLOW):
        """A folder with the journals of a run that reached a limit of the file size."""
        self.write("s.toml", text)
        stopped = self.culm(
            "run", "s.toml", "-o", "out", "-q",
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000)))
        self.assert_exit(stopped, STOPPED_EARLY)

    def table(self, folder: str):
        """Status, factors and results of every point: a pandas DataFrame."""
        with Study(self.folder / folder) as study:
            return study.table()


class Json(ArchiveTest):
    def test_follows_the_schema_for_a_whole_study(self):
        self.write("s.toml", FULL)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        for command in ("info", "status", "verify"):
            found = self.told(command, "out")
            self.assertEqual(found["points"],
                             {"total": 9, "completed": 9, "failed": 0, "missing": 0})
        self.assertTrue(found["is_whole"])
        self.assertIn("config", found["archive"]["provenance"])

    def test_follows_the_schema_for_journals_and_for_damage(self):
        self.interrupted()
        for command in ("info", "status", "verify"):
            found = self.told(command, "out")
            self.assertIsNone(found["archive"])
            self.assertEqual(found["points"]["total"], 24)
            self.assertEqual(found["points"]["missing"], len(found["missing_points"]))
        journal = next((self.folder / "out/journal").glob("*.culmj"))
        journal.write_bytes(journal.read_bytes()[:-9] + b"damaged!!")
        self.assertFalse(self.told("verify", "out")["is_whole"])
        (self.folder / "out/journal/study.json").unlink()
        self.assertIsNone(self.told("verify", "out")["points"])

    def test_follows_the_schema_for_a_running_study(self):
        self.write("s.toml", SLOW)
        process = self.start(PROGRAM, "run", "s.toml", "-o", "out", "-q")
        self.wait_for_points("out", 1)
        process.send_signal(signal.SIGSTOP)
        found = self.told("status", "out")
        process.send_signal(signal.SIGCONT)
        self.assertTrue(found["is_running"])
        self.assertGreater(len(found["unfinished_starts"]), 0)


class Waiting(ArchiveTest):
    # One point of some seconds: the second rank has no work.
    ONE_POINT = """
[stem]
spheres = 56
[vibration]
duration_s = 20
[factors]
bond_damping = [25]
bond_youngs_modulus_gpa = [4]
"""

    def test_ranks_are_listed_with_the_reason(self):
        self.write("s.toml", self.ONE_POINT)
        process = self.start(*launcher(2), PROGRAM, "run", "s.toml", "-o", "out", "-q")
        deadline = time.monotonic() + PATIENCE
        journals = []
        while len(journals) < 2 or sum(journal["is_waiting"] for journal in journals) != 1:
            self.assertLess(time.monotonic(), deadline)
            self.assertIsNone(process.poll(), "the study ended too early")
            if (self.folder / "out/journal/study.json").exists():
                journals = self.told("status", "out")["journals"]
        idle = next(k for k, journal in enumerate(journals) if journal["is_waiting"])
        self.assertRegex(self.culm("archive", "status", "out").stdout,
                         rf"rank {idle}    waits for \d+ s: the other ranks "
                         "compute all remaining points\n")
        self.assertRegex(self.culm("archive", "status", "out").stdout,
                         rf"rank {1 - idle}    computes 0 for \d+ s\n")

    def test_follow_prints_until_the_study_ends_and_expects_its_end(self):
        self.write("s.toml", self.ONE_POINT.replace("[25]", "[25, 26, 27]")
                   .replace("= 20", "= 10"))
        self.start(*launcher(1), PROGRAM, "run", "s.toml", "-o", "out", "-q")
        self.wait_for_points("out", 1)
        followed = self.culm("archive", "status", "out", "--follow")
        self.assert_exit(followed, DONE)
        self.assertRegex(followed.stdout, r"(?s)state +running\n.*rank 0 +computes [12]")
        self.assertRegex(followed.stdout, r"end       in about \d+ s\n")
        self.assertRegex(followed.stdout, r"\n\nstate +not running; archived\n")


class OlderFormats(ArchiveTest):
    def copied(self, name: str) -> str:
        shutil.copytree(OLDER / name, self.folder / name)
        shutil.copy(OLDER / "study.toml", self.folder)
        return name

    def test_archive_of_version_1_0_is_read_number_by_number(self):
        folder = self.copied("study-1.0")
        self.assertTrue(self.told("verify", folder)["is_whole"])
        with open(OLDER / "study-1.0/points.csv", encoding="utf-8", newline="") as file:
            expected = list(csv.DictReader(file))
        table = self.table(folder)
        self.assertEqual(len(table), len(expected))
        for name in table.columns.drop("status"):
            unit = table.attrs["units"][name]
            column = name if unit == "1" else f"{name} [{unit}]"
            self.assertEqual([float(row[column] or "nan") for row in expected],
                             list(table[name]), name)
        self.assert_exit(self.culm("reduce", folder, "--keep"), DONE)
        # The identity of a study had keys of settings that studies could choose then.
        resumed = self.culm("run", "study.toml", "-o", folder, "--resume")
        self.assert_exit(resumed, BAD_INPUT)
        self.assertIn("law.damping_factor: stored 2, not in the study now", resumed.stderr)

    @unittest.skipUnless(HAS_H5PY, "h5py is missing")
    def test_archive_of_a_newer_version_is_refused_with_what_to_do(self):
        import h5py
        folder = self.copied("study-1.0")
        with h5py.File(self.folder / folder / "study.h5", "r+") as file:
            file.attrs["format_version"] = "2.0"
        refused = self.culm("reduce", folder)
        self.assert_exit(refused, BAD_INPUT)
        self.assertIn("has format version 2.0; this culm reads version 1.x. It was written by culm "
                      "0.1.0 (4bdb53e-dirty): that version, or the newest one, reads it",
                      refused.stderr)

    def test_journal_of_another_version_is_refused_with_what_to_do(self):
        folder = self.copied("journal-1")
        journal = self.folder / folder / "journal/rank-00000.culmj"
        for version in (1, 3, 9):
            content = bytearray(journal.read_bytes())
            content[8] = version
            journal.write_bytes(content)
            refused = self.culm("run", "study.toml", "-o", folder, "--resume")
            self.assertIn(f"has journal format version {version}; this culm reads version 4. "
                          "Continue with the culm that began the study, or move the file away to "
                          "compute its points again", refused.stderr)
            self.assertNotEqual(refused.returncode, DONE)
            self.assertEqual(journal.read_bytes(), content)


class MissingData(ArchiveTest):
    def test_are_empty_in_tables_and_named_missing(self):
        self.interrupted()
        self.assert_exit(self.culm("archive", "merge", "out", "-o", "merged"), POINTS_FAILED)
        missing = self.told("verify", "merged")["missing_points"]
        self.assertGreater(len(missing), 10)
        table = self.table("merged")
        is_missing = table["status"] == "missing"
        self.assertEqual(list(table.index[is_missing]), missing)
        self.assertEqual(list(table["frequency"].isna()), list(is_missing))

    def test_are_not_called_failed_by_the_regressions(self):
        self.interrupted()
        self.assert_exit(self.culm("archive", "merge", "out", "-o", "merged"), POINTS_FAILED)
        missing = self.told("verify", "merged")["missing_points"]
        reduced = self.culm("reduce", "merged")
        self.assert_exit(reduced, POINTS_FAILED)
        self.assertRegex(reduced.stdout, rf"(?m)^{len(missing)} of \d+ points were not computed: ")
        self.assertNotIn("failed", reduced.stdout)
        summary = json.loads((self.folder / "merged/summary.json").read_text("utf-8"))
        self.assertEqual((summary["missing"], summary["failed"]), (missing, []))

    def test_are_empty_for_failed_points_with_the_reason(self):
        # Stiff stems swing faster than the formula allows.
        self.write("bounded.toml", BOUNDED)
        self.write("s.toml", '[study]\neffects = ["bounded.toml"]\n' + QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), POINTS_FAILED)
        table = self.table("out")
        failed = table[table["status"] == "failed"]
        self.assertEqual(set(failed["bond_youngs_modulus_gpa"]), {4.0, 9.0})
        self.assertTrue(failed["frequency"].isna().all())
        with Study(self.folder / "out") as study:
            for failure in study.failures:
                self.assertEqual(failure.kind, "user_expression")
                self.assertIn("is not a number at", failure.reason)
        self.assertEqual(len(self.told("verify", "out")["failed_points"]), len(failed))

    def test_are_empty_for_histories_without_a_fit(self):
        self.write("s.toml", OVERDAMPED)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), POINTS_FAILED)
        table = self.table("out")
        self.assertEqual(list(table["bond_damping"][table["frequency"].isna()]), [30000.0] * 3)

    @unittest.skipUnless(HAS_H5PY, "h5py is missing")
    def test_are_not_a_number_for_other_readers_and_never_zero(self):
        import h5py
        import numpy
        self.interrupted()
        self.assert_exit(self.culm("archive", "merge", "out", "-o", "merged"), POINTS_FAILED)
        with h5py.File(self.folder / "merged/study.h5") as file:
            missing = file["results/status"][:] == 2
            self.assertTrue(missing.any())
            self.assertTrue(numpy.isnan(file["results/frequency"][:][missing]).all())
            tip = file["histories/tip_deflection"]
            self.assertTrue(math.isnan(tip.fillvalue))
            self.assertTrue(numpy.isnan(tip[:][missing]).all())
            self.assertTrue(numpy.isfinite(tip[:][~missing]).all())

    @unittest.skipUnless(HAS_H5PY, "h5py is missing")
    def test_absent_chunks_are_damage_and_no_fill_values(self):
        import h5py
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        with h5py.File(self.folder / "out/study.h5", "r+") as file:
            old = file["histories/tip_deflection"]
            shape, chunks = old.shape, old.chunks
            del file["histories/tip_deflection"]
            new = file.create_dataset("histories/tip_deflection", shape, "f8", chunks=chunks,
                                      fletcher32=True, fillvalue=0.0)
            new.attrs["unit"] = "m"
        found = self.told("verify", "out")
        self.assertFalse(found["is_whole"])
        self.assertEqual([entry["dataset"] for entry in found["archive"]["damaged"]],
                         ["/histories/tip_deflection"])
        self.assert_exit(self.culm("reduce", "out", "--keep"), BAD_INPUT)


class OtherReaders(ArchiveTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", FULL)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        self.archive = str(self.folder / "out/study.h5")

    @unittest.skipUnless(shutil.which("h5dump"), "h5dump (hdf5-tools) is missing")
    def test_h5dump_reads_headers_and_numbers(self):
        headers = subprocess.run(["h5dump", "-H", self.archive], capture_output=True, text=True,
                                 check=True).stdout
        for text in ('DATASET "tip_deflection"', 'GROUP "h5md"', 'ATTRIBUTE "format_version"',
                     'DATASET "frequency"'):
            self.assertIn(text, headers)
        numbers = subprocess.run(["h5dump", "-d", "/results/frequency", "-m", "%.17g", "-y",
                                  self.archive], capture_output=True, text=True, check=True).stdout
        printed = re.search(r"DATA \{(.*?)\}", numbers, re.DOTALL)[1]
        expected = list(self.table("out")["frequency"])
        self.assertEqual([float(text) for text in printed.replace(",", " ").split()], expected)

    @unittest.skipUnless(HAS_H5PY, "h5py is missing")
    def test_h5py_reads_what_the_tables_say(self):
        import h5py
        with h5py.File(self.archive) as file:
            found = file["results/decay_per_cycle"][:].tolist()
        self.assertEqual(found, list(self.table("out")["decay_per_cycle"]))

    @unittest.skipUnless(importlib.util.find_spec("MDAnalysis") and HAS_H5PY,
                         "MDAnalysis (python3-mdanalysis) is missing")
    def test_mdanalysis_reads_a_trajectory(self):
        import h5py
        import MDAnalysis
        import numpy
        from MDAnalysis.coordinates.H5MD import H5MDReader
        H5MDReader._unit_translation["length"]["m"] = "m"
        self.assert_exit(self.culm("archive", "merge", "out", "-o", "one-file"), DONE)
        self.assertTrue((self.folder / "out/trajectories").is_dir())
        self.assertFalse((self.folder / "one-file/trajectories").exists())
        for folder in ("out", "one-file"):
            archive = str(self.folder / folder / "study.h5")
            universe = MDAnalysis.Universe.empty(15)
            universe.load_new(archive, format="H5MD", convert_units=False)
            with h5py.File(archive) as file:
                expected = file["particles/point_000000/position/value"][:]
            self.assertEqual(len(universe.trajectory), len(expected))
            for frame in (0, 17, len(expected) - 1):
                universe.trajectory[frame]
                # MDAnalysis keeps positions in single precision.
                self.assertTrue(numpy.allclose(universe.atoms.positions, expected[frame],
                                               rtol=1e-6, atol=1e-9))

    @unittest.skipUnless(HAS_H5PY, "h5py is missing")
    def test_single_precision_is_that_of_the_stored_numbers(self):
        import numpy
        self.write("short.toml", FULL + '\n[archive]\ntrajectory_precision = "float32"\n')
        self.assert_exit(self.culm("run", "short.toml", "-o", "short", "-q"), DONE)
        self.assert_exit(self.culm("archive", "merge", "short", "-o", "short-merged"), DONE)
        with Study(self.folder / "out") as study:
            expected = study.positions(1).astype(numpy.float32)
        for folder in ("short", "short-merged"):
            with Study(self.folder / folder) as study:
                self.assertEqual(study.position_bytes, 4)
                self.assertTrue((study.positions(1) == expected).all())


if __name__ == "__main__":
    unittest.main()
