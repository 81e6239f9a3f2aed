# SPDX-License-Identifier: BSD-3-Clause
"""A study that runs to its end: files, exit codes, the dry run, and folders in use."""

import csv
import json
import unittest

from culm_program import BAD_INPUT, DONE, OVERDAMPED, POINTS_FAILED, QUICK, CulmTest


class Run(CulmTest):
    def test_writes_archive_summary_and_fits_and_prints_the_regressions(self):
        study = self.write("s.toml", QUICK)
        finished = self.culm("run", study, "-o", "out")
        self.assert_exit(finished, DONE)
        self.assertEqual({path.name for path in (self.folder / "out").iterdir()},
                         {"study.h5", "summary.json", "fits.csv"})
        summary = json.loads((self.folder / "out/summary.json").read_text(encoding="utf-8"))
        self.assertEqual((summary["points"], summary["completed"], summary["failed"]), (9, 9, []))
        with open(self.folder / "out/fits.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([float(row["bond_damping"]) for row in rows],
                         [5, 5, 5, 10, 10, 10, 15, 15, 15])
        self.assertIn("9 of 9 points completed", finished.stdout)
        self.assertIn("archive out/study.h5\nsummary out/summary.json\n", finished.stdout)
        slope = summary["regression"]["sqrt_youngs_modulus"]["slope"]
        self.assertIn(f"sqrt(Y) = {slope:.2f} b2", finished.stdout)

    def test_writes_to_results_and_the_study_name_without_a_folder(self):
        study = self.write("s.toml", '[study]\nname = "first"\n' + QUICK)
        self.assert_exit(self.culm("run", study), DONE)
        self.assertTrue((self.folder / "results/first/study.h5").is_file())

    def test_prints_no_progress_if_quiet(self):
        study = self.write("s.toml", QUICK)
        self.assertIn("9/9 points", self.culm("run", study, "-o", "loud").stderr)
        self.assertEqual(self.culm("run", study, "-o", "quiet", "-q").stderr, "")

    def test_lists_failed_points_and_ends_with_their_code(self):
        study = self.write("s.toml", OVERDAMPED)
        finished = self.culm("run", study, "-o", "out")
        self.assert_exit(finished, POINTS_FAILED)
        self.assertIn("\n3 of 9 points failed:\n    point 6: fit_failed: ", finished.stdout)
        summary = json.loads((self.folder / "out/summary.json").read_text(encoding="utf-8"))
        self.assertEqual(summary["completed"], 6)
        self.assertEqual([failed["point"] for failed in summary["failed"]], [6, 7, 8])
        for failed in summary["failed"]:
            self.assertEqual(failed["kind"], "fit_failed")
            self.assertGreater(len(failed["reason"]), 20)
        self.assert_exit(self.culm("run", study, "-o", "out", "--resume"), POINTS_FAILED)


class DryRun(CulmTest):
    def printed(self, text: str) -> dict[str, str]:
        """The lines of a plan; the run must have written nothing."""
        study = self.write("s.toml", text)
        finished = self.culm("run", study, "-o", "out", "--dry-run")
        self.assert_exit(finished, DONE)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["s.toml"])
        self.assertEqual(finished.stderr, "")
        lines = {}
        for line in finished.stdout.splitlines():
            lines[line[:15].strip()] = line[15:]
        return lines

    def test_prints_the_plan_of_an_implicit_study_and_writes_nothing(self):
        plan = self.printed(QUICK)
        self.assertRegex(plan["points"], r"^9 in \d+ batch(es)?, up to \d+ SIMD lanes each$")
        self.assertEqual(plan["integrator"], "implicit, relative tolerance 2e-06")
        self.assertRegex(plan["estimated cost"], r"^[\d.e+-]+ core seconds, [\d.e+-]+ s on 1 rank$")
        self.assertRegex(plan["memory"], r"^\d+(\.\d+)? MB per rank$")
        # 9 points of 1001 samples and 12 results.
        self.assertEqual(plan["archive"], "72.9 kB before compression")
        self.assertEqual(plan["output"], "out")

    def test_states_the_lanes_and_the_steps_of_an_explicit_study(self):
        plan = self.printed('[integrator]\nmethod = "explicit"\ntimestep_s = 1e-10\n' + QUICK)
        self.assertRegex(plan["points"], r"^9 in \d+ batch(es)?, up to \d+ SIMD lanes each$")
        self.assertEqual(plan["integrator"],
                         "explicit, time step 1e-10 s, 5e+08 steps a point")

    def test_refuses_what_a_run_refuses(self):
        study = self.write("s.toml", "[stem]\nspheres = 1\n")
        self.assert_exit(self.culm("run", study, "--dry-run"), BAD_INPUT)


class TakenFolder(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        self.archive = (self.folder / "out/study.h5").read_bytes()

    def test_asks_for_resume_if_it_has_this_study(self):
        self.assert_refused(
            self.culm("run", "s.toml", "-o", "out"),
            "culm: out already holds this study, whole or in part; add --resume to compute only "
            "what is missing, or choose another folder with -o\n")

    def test_is_refused_with_the_difference_if_it_has_another_study(self):
        self.write("other.toml", QUICK + "[reduce]\nsignificance = 0.01\n")
        for options in ([], ["--resume"]):
            self.assert_refused(
                self.culm("run", "other.toml", "-o", "out", *options),
                "culm: out already holds another study; choose another folder with -o. What "
                "differs:\n"
                "reduce.significance: stored 0.05, now 0.01\n")
        self.assertEqual((self.folder / "out/study.h5").read_bytes(), self.archive)

    def test_is_only_reduced_again_by_resume_if_it_is_finished(self):
        (self.folder / "out/summary.json").unlink()
        finished = self.culm("run", "s.toml", "-o", "out", "--resume")
        self.assert_exit(finished, DONE)
        self.assertNotIn("points/s", finished.stderr)
        self.assertTrue((self.folder / "out/summary.json").is_file())
        self.assertEqual((self.folder / "out/study.h5").read_bytes(), self.archive)

    def test_has_the_same_study_if_only_its_name_differs(self):
        self.write("renamed.toml", "# The same numbers.\n[study]\nname = \"renamed\"\n" + QUICK)
        self.assert_exit(self.culm("run", "renamed.toml", "-o", "out", "--resume"), DONE)


if __name__ == "__main__":
    unittest.main()
