# SPDX-License-Identifier: BSD-3-Clause
"""The JSON that culm writes follows `culm schema`, and every schema has such a test."""

import json
import re
import sys
import unittest
from pathlib import Path

from culm_program import DONE, OVERDAMPED, POINTS_FAILED, QUICK, CulmTest
from test_track import PICTURES, VIDEO

TESTS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TESTS / "support"))
from json_schema import schema_faults, schema_of  # noqa: E402

SUMMARY = schema_of("summary")
TRACK = schema_of("track")

POPULATION = """
[stem]
spheres = 12
length_mm = 150
[vibration]
duration_s = 0.05
[factors]
bond_damping = { distribution = "normal", mean = 8, sd = 2, min = 3, max = 14, within_sd = 0.5 }
bond_youngs_modulus_gpa = { distribution = "uniform", min = 1, max = 3 }
[replicates]
stems = 8
within = 2
"""

# The limits of this short chain are found quickly; without damping one law has no points.
TIMESTEP = """
[study]
kind = "timestep"
[stem]
spheres = 8
length_mm = 60
[release]
tip_deflection_mm = 3
[factors]
bond_damping = {damping}
[timestep]
fractions = {fractions}
"""


class Summary(CulmTest):
    def assert_follows(self, study: str, exit_code: int = DONE):
        self.assert_exit(self.culm("run", self.write("study.toml", study), "-o", "out", "-q"),
                         exit_code)
        summary = json.loads((self.folder / "out" / "summary.json").read_text("utf-8"))
        self.assertEqual(schema_faults(summary, SUMMARY), [])
        summary["wall_seconds"] = summary.pop("wall_s")
        self.assertNotEqual(schema_faults(summary, SUMMARY), [])

    def test_follows_its_schema_for_a_factorial_design(self):
        self.assert_follows(QUICK)

    def test_follows_its_schema_for_a_design_with_failed_points(self):
        self.assert_follows(OVERDAMPED, POINTS_FAILED)

    def test_follows_its_schema_for_one_point_without_a_law(self):
        self.assert_follows("[stem]\nspheres = 12\nlength_mm = 150\n")

    def test_follows_its_schema_for_stems_with_several_tests(self):
        self.assert_follows(POPULATION)

    def test_follows_its_schema_for_time_steps(self):
        self.assert_follows(TIMESTEP.format(damping=[0, 5, 20], fractions=[0.25, 0.5, 0.95]))

    def test_follows_its_schema_for_time_steps_without_damping(self):
        self.assert_follows(TIMESTEP.format(damping=[0], fractions=[0.5]))


class Track(CulmTest):
    def test_reports_a_video_by_its_schema(self):
        (self.folder / "frames").mkdir()
        for number, picture in enumerate(PICTURES):
            (self.folder / f"frames/{number:03d}.pgm").write_bytes(picture)
        self.write("A.toml", VIDEO.format(frames="frames", name="A"))
        self.assert_exit(self.culm("track", "A.toml", "-o", "A"), DONE)
        report = json.loads((self.folder / "A" / "track.json").read_text("utf-8"))
        self.assertEqual(schema_faults(report, TRACK), [])
        del report["swing_hz"]
        self.assertNotEqual(schema_faults(report, TRACK), [])


class EverySchema(CulmTest):
    def test_is_compared_with_what_the_program_writes(self):
        tests = "".join(file.read_text("utf-8") for file in Path(__file__).parent.glob("test_*.py"))
        tested = set(re.findall(r'schema_of\("([a-z]+)"\)', tests))
        listed = self.culm("schema").stdout
        self.assertEqual(tested, {line.split()[0] for line in listed.splitlines()})

    def test_is_refused_under_a_wrong_name_with_the_nearest(self):
        self.assert_refused(self.culm("schema", "sumary"),
                            'culm: there is no document "sumary" (did you mean "summary"?)\n')


if __name__ == "__main__":
    unittest.main()
