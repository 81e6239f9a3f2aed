# SPDX-License-Identifier: BSD-3-Clause
"""culm run --resume extends a study: old points are kept, and the result is that of a fresh study."""

import re
import shutil
import subprocess
import unittest

from culm_program import (BAD_INPUT, DONE, PROGRAM, STOPPED_EARLY, CulmTest, contents,
                          launcher)

STEM = """
[stem]
spheres = 12
length_mm = 155.65
[vibration]
duration_s = 0.05
"""


def grid(modulus: str, head: str = "", damping: str = "[5, 8, 11, 14]") -> str:
    return head + STEM + f"[factors]\nbond_damping = {damping}\n" \
        f"bond_youngs_modulus_gpa = {modulus}\n"


# 4 dampings and 20 moduli, 80 points; then 30 moduli, with new ones between the old ones.
GRID_80 = grid("{from = 1, to = 20, step = 1}")
GRID_120 = grid("[" + ", ".join(f"{0.5 * k:g}" for k in range(2, 23)) + ", 12, 13, 14, 15, 16, 17, "
                "18, 19, 20]")

SOBOL = STEM + """
[factors]
bond_damping = {distribution = "uniform", min = 5, max = 15}
bond_youngs_modulus_gpa = {distribution = "uniform", min = 1, max = 9}
[design]
type = "sobol"
points = %d
"""

REPLICATES = STEM + """
[factors]
bond_damping = [5, 10]
bond_youngs_modulus_gpa = {distribution = "normal", mean = 4, sd = 0.5, min = 1}
[replicates]
stems = %d
"""


class ExtendTest(CulmTest):
    def run_study(self, text: str, folder: str, *options, ranks: int = 1):
        self.write("s.toml", text)
        start = launcher(ranks) if ranks > 1 else []
        return subprocess.run([*start, PROGRAM, "run", "s.toml", "-o", folder, "-q", *options],
                              cwd=self.folder, text=True, capture_output=True, check=False)

    def contents(self, folder: str) -> dict[str, bytes]:
        return contents(self.folder, folder)


class Extend(ExtendTest):
    def assert_extends(self, small: str, large: str, kept: str, ranks: int = 1):
        """`kept`: what the message says, "80 of 120"."""
        self.assert_exit(self.run_study(small, "grown"), DONE)
        extended = self.run_study(large, "grown", "--resume", ranks=ranks)
        self.assert_exit(extended, DONE)
        self.assertIn(f"the study in grown is extended: {kept} points are there", extended.stderr)
        self.assert_exit(self.run_study(large, "fresh"), DONE)
        self.assertEqual(self.contents("grown"), self.contents("fresh"))
        for table in ("fits.csv", "summary.json"):
            grown, fresh = ((self.folder / folder / table).read_text("utf-8")
                            for folder in ("grown", "fresh"))
            if table == "summary.json":
                grown, fresh = (re.sub(r'"(wall_s|ranks|archive)": [^,\n]*', "", text)
                                for text in (grown, fresh))
            self.assertEqual(grown, fresh, table)
        self.assertEqual(self.culm("archive", "verify", "grown").returncode, DONE)

    def test_by_levels_between_and_beyond_the_old_ones(self):
        self.assert_extends(GRID_80, GRID_120, "80 of 120", ranks=2)

    def test_by_sobol_points(self):
        self.assert_extends(SOBOL % 16, SOBOL % 24, "16 of 24")

    def test_by_replicates_which_keep_the_draws_of_the_old_ones(self):
        self.assert_extends(REPLICATES % 3, REPLICATES % 5, "6 of 10")

    def test_keeps_trajectories(self):
        head = '[study]\nstore = "full"\n'
        small, large = grid("[1, 4]", head, "[5, 10]"), grid("[1, 2, 4]", head, "[5, 10]")
        self.assert_extends(small, large, "4 of 6")

    def test_by_another_height_computes_all_points_and_keeps_the_former_archive(self):
        text = grid("[1, 4]", '[study]\nstore = "heights"\nheights_mm = [%s]\n', "[5, 10]")
        self.assert_exit(self.run_study(text % "60", "grown"), DONE)
        before = (self.folder / "grown/study.h5").read_bytes()
        extended = self.run_study(text % "60, 120", "grown", "--resume")
        self.assert_exit(extended, DONE)
        self.assertIn("its points are computed again, and the former archive stays in "
                      "grown/study-before-extension.h5", extended.stderr)
        self.assertEqual((self.folder / "grown/study-before-extension.h5").read_bytes(), before)
        self.assert_exit(self.run_study(text % "60, 120", "fresh"), DONE)
        self.assertEqual(self.contents("grown"), self.contents("fresh"))

    def test_by_the_same_heights_in_another_order_keeps_no_history(self):
        text = grid("[1, 4]", '[study]\nstore = "heights"\nheights_mm = [%s]\n', "[5, 10]")
        self.assert_exit(self.run_study(text % "60, 120", "grown"), DONE)
        self.assert_exit(self.run_study(text % "120, 60", "grown", "--resume"), DONE)
        self.assert_exit(self.run_study(text % "120, 60", "fresh"), DONE)
        self.assertEqual(self.contents("grown"), self.contents("fresh"))

    def stop_a_small_study(self) -> str:
        """Stops the study "grown" after four points; the text of the study that extends it."""
        slow = "spheres = 12", "spheres = 56"
        self.write("slow.toml", GRID_80.replace(*slow))
        process = self.start(PROGRAM, "run", "slow.toml", "-o", "grown", "-q")
        self.wait_for_points("grown", 4)
        process.terminate()
        process.communicate()
        self.assertEqual(process.returncode, STOPPED_EARLY)
        return GRID_120.replace(*slow)

    def test_of_a_study_that_was_stopped_keeps_what_it_has(self):
        large = self.stop_a_small_study()
        extended = self.run_study(large, "grown", "--resume", ranks=2)
        self.assert_exit(extended, DONE)
        kept = int(re.search(r"is extended: (\d+) of 120 points are there", extended.stderr)[1])
        self.assertGreaterEqual(kept, 4)
        self.assert_exit(self.run_study(large, "fresh", ranks=2), DONE)
        self.assertEqual(self.contents("grown"), self.contents("fresh"))

    def test_interrupted_before_it_removed_the_journals_goes_on(self):
        large = self.stop_a_small_study()
        shutil.copytree(self.folder / "grown/journal", self.folder / "absorbed")
        # Stops at once: the archive is that of the large study, without its new points.
        stopped = self.run_study(large, "grown", "--resume", "--walltime", "1s")
        self.assertNotEqual(stopped.returncode, DONE)
        shutil.rmtree(self.folder / "grown/journal", ignore_errors=True)
        shutil.copytree(self.folder / "absorbed", self.folder / "grown/journal")
        self.assert_exit(self.run_study(large, "grown", "--resume", ranks=2), DONE)
        self.assertEqual(self.culm("archive", "verify", "grown").returncode, DONE)

    def assert_refused(self, small: str, large: str, *words: str):
        if not (self.folder / "kept").exists():
            self.assert_exit(self.run_study(small, "kept"), DONE)
        before = (self.folder / "kept/study.h5").read_bytes()
        refused = self.run_study(large, "kept", "--resume")
        self.assert_exit(refused, BAD_INPUT)
        for word in words:
            self.assertIn(word, refused.stderr)
        self.assertEqual((self.folder / "kept/study.h5").read_bytes(), before)

    def test_is_refused_if_a_point_is_lacking(self):
        small = grid("[1, 4]", damping="[5, 10]")
        self.assert_refused(
            small, grid("[1, 9, 16]", damping="[5, 10]"),
            "s.toml does not extend the stored study: it lacks the stored point 1 (bond_damping = "
            "5, bond_youngs_modulus_gpa = 4). What differs:\n",
            "factors.bond_youngs_modulus_gpa: stored [1, 4], now [1, 9, 16]\nChoose another folder "
            "with -o\n")
        self.assert_refused(small, small.replace("spheres = 12", "spheres = 13"),
                            "kept already holds another study", "stem.spheres: stored 12, now 13")
        self.assert_refused(small, small + "tip_deflection_mm = [10, 15]\n",
                            "kept already holds another study", "tip_deflection_mm")

    def test_is_refused_for_a_latin_hypercube_with_the_reason(self):
        hypercube = (SOBOL % 8).replace("sobol", "latin_hypercube")
        self.assert_refused(hypercube, hypercube.replace("points = 8", "points = 12"),
                            "a Latin hypercube with another number of points has other points")

    def test_needs_resume(self):
        self.assert_exit(self.run_study(GRID_80, "kept"), DONE)
        refused = self.run_study(GRID_120, "kept")
        self.assert_exit(refused, BAD_INPUT)
        self.assertIn("kept already holds another study", refused.stderr)


class Parts(ExtendTest):
    def test_merge_to_the_whole_study(self):
        for part in (1, 2, 3):
            finished = self.run_study(GRID_80, f"part-{part}", "--part", f"{part}/3")
            self.assert_exit(finished, DONE)
            self.assertIn(f"part {part}/3 is complete in part-{part}", finished.stdout)
        merged = self.culm("archive", "merge", "part-1", "part-2", "part-3", "-o", "whole")
        self.assert_exit(merged, DONE)
        self.assertIn("80 points: 80 completed, 0 failed, 0 missing", merged.stdout)
        self.assert_exit(self.run_study(GRID_80, "fresh"), DONE)
        self.assertEqual(self.contents("whole"), self.contents("fresh"))

    def test_are_refused_if_there_is_no_such_part(self):
        for part in ("0/3", "4/3", "3", "1/0", "a/b", "1/3x"):
            refused = self.run_study(GRID_80, "wrong", "--part", part)
            self.assert_exit(refused, BAD_INPUT)
            self.assertIn(f"--part {part}: must be K/N with K from 1 to N, for example 2/4",
                          refused.stderr)


if __name__ == "__main__":
    unittest.main()
