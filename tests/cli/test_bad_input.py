# SPDX-License-Identifier: BSD-3-Clause
"""All errors of a study are reported before any work, with exit code 2."""

import unittest

from culm_program import BAD_INPUT, QUICK, CulmTest


class BadStudy(CulmTest):
    def refused(self, text: str, message: str):
        study = self.write("s.toml", text)
        self.assert_refused(self.culm("run", study, "-o", "out"), message)
        self.assertFalse((self.folder / "out").exists())

    def test_is_refused_if_it_is_missing(self):
        self.assert_refused(self.culm("run", "no.toml"),
                            "culm: no.toml: cannot be read: No such file or directory\n")

    def test_is_refused_if_it_is_a_folder(self):
        self.assert_refused(self.culm("run", "."), "culm: .: cannot be read: it is a folder\n")

    def test_shows_the_line_that_is_not_toml(self):
        study = self.write("s.toml", "[stem]\nspheres = = 3\n")
        finished = self.culm("run", study)
        self.assert_exit(finished, BAD_INPUT)
        self.assertRegex(finished.stderr, r"^culm: s\.toml:2: not valid TOML: \w.*\n$")

    def test_gets_the_nearest_name_for_an_unknown_law(self):
        self.refused('[law]\nname = "schram2019"\n',
                     'culm: s.toml:2: law.name = "schram2019": must be "schramm2019" or '
                     '"consistent" (did you mean "schramm2019"?)\n')

    def test_is_refused_for_a_value_that_is_not_a_number(self):
        self.refused("[stem]\nbond_damping = nan\n",
                     "culm: s.toml:2: stem.bond_damping = nan: must be a number in [0, 100000]\n")

    def test_is_refused_for_a_negative_parameter(self):
        self.refused("[stem]\ndensity_kg_m3 = -125\n",
                     "culm: s.toml:2: stem.density_kg_m3 = -125: must be a number in "
                     "(0, 30000] kg/m³\n")

    def test_gets_all_of_its_errors_at_once(self):
        self.refused(
            '[law]\nname = "consistant"\n'
            "[stem]\nsphres = 4\nlength_mm = -3\n"
            "[factors]\nbond_damping = [1, inf]\n",
            'culm: s.toml:2: law.name = "consistant": must be "schramm2019" or "consistent" (did '
            'you mean "consistent"?)\n'
            "s.toml:4: stem.sphres = 4: unknown key (did you mean spheres?)\n"
            "s.toml:5: stem.length_mm = -3: must be a number in (0, 100000] mm\n"
            "s.toml:7: factors.bond_damping = inf: must be a number in [0, 100000]\n")

    def test_gets_the_limit_of_an_explicit_step_that_is_too_large(self):
        study = self.write("s.toml", '[integrator]\nmethod = "explicit"\ntimestep_s = 1e-8\n'
                                     "[stem]\nspheres = 10\n"
                                     "[factors]\nbond_damping = [1, 100, 200]\n")
        finished = self.culm("run", study, "-o", "out")
        self.assert_exit(finished, BAD_INPUT)
        # Both limits depend on the damping only: twice the damping halves the step.
        self.assertEqual(
            finished.stderr,
            "culm: s.toml: 2 of 3 points are impossible:\n"
            "  point 1: integrator.timestep_s = 1e-08 is above the largest stable step of the "
            "linearised chain, 2.96e-09 s (bond_damping = 100)\n"
            "  point 2: integrator.timestep_s = 1e-08 is above the largest stable step of the "
            "linearised chain, 1.48e-09 s (bond_damping = 200)\n"
            "  every point is stable with integrator.timestep_s = 1.48e-09 or less\n")
        self.assertFalse((self.folder / "out").exists())


class BadOption(CulmTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", QUICK)

    def test_is_refused_if_it_is_not_a_finite_number_in_range(self):
        cases = {
            ("--bond-damping", "nan"): "[0, 100000]",
            ("--bond-damping", "-1"): "[0, 100000]",
            ("--bond-youngs-modulus-gpa", "0"): "(0, 10000]",
            ("--bond-youngs-modulus-gpa", "nan"): "(0, 10000]",
            ("--frequency-hz", "inf"): "(0, 1000000]",
            ("--decay-per-cycle", "0.4"): "[-10, 0)",
        }
        for (option, value), allowed in cases.items():
            self.assert_refused(
                self.culm("simulate", "s.toml", f"{option}={value}"),
                f"culm simulate: {option}: {value} is not a number in {allowed}\n"
                "Try `culm simulate --help`.\n")

    def test_is_named_if_simulate_lacks_it(self):
        self.assert_refused(self.culm("simulate"),
                            "culm: simulate needs a study file, or --via DIR\n")
        self.assert_refused(self.culm("simulate", "s.toml", "--via", "out"),
                            "culm: simulate takes a study file or --via DIR, not both\n")
        self.assert_refused(
            self.culm("simulate", "s.toml", "--bond-damping", "3"),
            "culm: a study file needs --bond-youngs-modulus-gpa and --bond-damping; to calibrate "
            "them from a study that has run, give --via DIR\n")
        self.assert_refused(
            self.culm("simulate", "--via", "out", "--frequency-hz", "3"),
            "culm: --via DIR needs --frequency-hz and --decay-per-cycle, the measured b2 and b1 of "
            "the stem\n")

    def test_is_refused_if_the_folder_has_no_study(self):
        message = "culm: out: there is no study here (study.h5 is missing)\n"
        self.assert_refused(self.culm("reduce", "out"), message)
        self.assert_refused(self.culm("simulate", "--via", "out", "--frequency-hz", "90",
                                      "--decay-per-cycle", "-0.3"), message)


if __name__ == "__main__":
    unittest.main()
