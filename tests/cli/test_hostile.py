# SPDX-License-Identifier: BSD-3-Clause
"""Hostile and careless input: paths cannot lead out of their folder, endless files are read up to a
limit, formulas are bounded, and altered archives are refused."""

import importlib.util
import unittest

from culm_program import BAD_INPUT, DONE, POINTS_FAILED, QUICK, CulmTest

HAS_H5PY = importlib.util.find_spec("h5py") is not None

EFFECT = """
[effect]
name = "mine"
kind = "force_per_length"
expression = "{formula}"
[parameters.c]
default = 1e-4
lower = 0
upper = 1
"""

VIDEO = """
[video]
frames = "{frames}"
fps = 1000
mm_per_px = 0.1
[stem]
id = "v"
length_mm = 150
diameter_mm = 3
density_kg_m3 = 200
"""

MAPPING = """
[stem]
id = "m"
length_mm = 100
diameter_mm = 3
density_kg_m3 = 125
[source]
file = "{file}"
[time]
column = "t"
release_s = 0
[motion]
unit = "mm"
zero = "as_given"
[[height]]
height_mm = 50
columns = "a"
"""

ELSEWHERE = "must lie in the folder of the file that names it, or below"


class Paths(CulmTest):
    def setUp(self):
        super().setUp()
        (self.folder / "study" / "sub").mkdir(parents=True)
        self.write("outside.toml", EFFECT.format(formula="-c*v"))
        self.write("study/sub/inside.toml", EFFECT.format(formula="-c*v"))

    def study(self, effect: str) -> str:
        return self.write("study/s.toml", f'[study]\neffects = ["{effect}"]\n' + QUICK)

    def test_stay_in_the_folder_of_the_study_for_effects(self):
        for name in ("../outside.toml", str(self.folder / "outside.toml"), "/etc/passwd",
                     "sub/../../outside.toml"):
            refused = self.culm("run", self.study(name), "--dry-run")
            self.assert_exit(refused, BAD_INPUT)
            self.assertIn(ELSEWHERE, refused.stderr)
        self.assert_exit(self.culm("run", self.study("sub/inside.toml"), "--dry-run"), DONE)
        self.assert_exit(self.culm("run", self.study("./sub/../sub/inside.toml"), "--dry-run"),
                         DONE)

    def test_may_be_symbolic_links_that_the_owner_of_the_folder_made(self):
        (self.folder / "study/link.toml").symlink_to(self.folder / "outside.toml")
        self.assert_exit(self.culm("run", self.study("link.toml"), "--dry-run"), DONE)

    def test_lead_anywhere_on_the_command_line(self):
        self.write("study/s.toml", QUICK)
        self.assert_exit(self.culm("effects", str(self.folder / "outside.toml")), DONE)

    def test_stay_in_the_folder_of_the_description_for_recordings(self):
        for name in ("../frames/%05d.png", "/tmp/%05d.png"):
            self.write("study/video.toml", VIDEO.format(frames=name))
            refused = self.culm("track", "study/video.toml", "-o", "out")
            self.assert_exit(refused, BAD_INPUT)
            self.assertIn(ELSEWHERE, refused.stderr)
        self.write("table.csv", "t,a\n0,1\n0.1,2\n0.2,3\n")
        for name in ("../table.csv", str(self.folder / "table.csv")):
            self.write("study/import.toml", MAPPING.format(file=name))
            refused = self.culm("import", "study/import.toml", "-o", "out")
            self.assert_exit(refused, BAD_INPUT)
            self.assertIn(ELSEWHERE, refused.stderr)
            self.assertIn("--recording", refused.stderr)
        self.write("study/import.toml", MAPPING.format(file="table.csv"))
        self.assert_exit(self.culm("import", "study/import.toml", "-o", "out", "--recording",
                                   "table.csv"), DONE)


class Endless(CulmTest):
    def test_files_are_read_up_to_a_limit(self):
        for command in (["run", "/dev/zero"], ["effects", "./endless.toml"],
                        ["export", "lammps", "/dev/zero"]):
            (self.folder / "endless.toml").unlink(missing_ok=True)
            (self.folder / "endless.toml").symlink_to("/dev/zero")
            refused = self.culm(*command)
            self.assert_exit(refused, BAD_INPUT)
            self.assertIn("cannot be read: it is larger than 64 MiB", refused.stderr)

    def test_designs_are_refused_before_they_fill_the_memory(self):
        self.write("s.toml", "[factors]\n"
                   "bond_damping = {from = 1, to = 2, count = 1000000}\n"
                   "bond_youngs_modulus_gpa = {from = 1, to = 2, count = 1000000}\n")
        refused = self.culm("run", "s.toml", "--dry-run")
        self.assert_exit(refused, BAD_INPUT)
        self.assertIn("1e+12 points, replicates included; at most 100000000 are possible", refused.stderr)


class Formulas(CulmTest):
    def refusal(self, formula: str) -> str:
        self.write("mine.toml", EFFECT.format(formula=formula))
        refused = self.culm("effects", "./mine.toml")
        self.assert_exit(refused, BAD_INPUT)
        return refused.stderr

    def test_are_bounded_in_length_depth_and_operations(self):
        self.assertIn("1005 characters; 1000 are allowed", self.refusal("-c" + "*v" * 501 + "*"))
        self.assertIn("nested deeper than 50", self.refusal("(" * 51 + "v" + ")" * 51))
        # Operators and functions nest like parentheses. Their depth has no separate bound; it is
        # bounded by the length.
        self.write("mine.toml", EFFECT.format(formula="-c*v" + "*1" * 498))
        self.assert_exit(self.culm("effects", "./mine.toml"), DONE)

    def test_can_name_no_files_and_no_commands(self):
        for formula in ("system(1)", "v; v", "`ls`", "$(ls)", "import(os)"):
            self.assertIn("mine.toml", self.refusal(formula))


@unittest.skipUnless(HAS_H5PY, "h5py is missing")
class AlteredArchives(CulmTest):
    """Deliberate alterations, with right checksums."""

    def setUp(self):
        super().setUp()
        self.write("s.toml", '[study]\nstore = "full"\nheights_mm = [60]\n' + QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "whole", "-q"), DONE)

    def replace(self, file, name: str, data, **options):
        attributes = dict(file[name].attrs)
        del file[name]
        dataset = file.create_dataset(name, data=data, **options)
        for key, value in attributes.items():
            dataset.attrs[key] = value

    def alterations(self):
        import h5py
        import numpy
        chunked = {"chunks": True, "fletcher32": True}
        text = h5py.string_dtype()
        yield "too few numbers", lambda f: self.replace(f, "design/bond_damping", numpy.ones(4),
                                                        **chunked)
        yield "too many numbers", lambda f: self.replace(f, "design/bond_damping",
                                                         numpy.ones(4000), **chunked)
        yield "no row", lambda f: self.replace(f, "results/frequency", 1.0)
        yield "texts for numbers", lambda f: self.replace(f, "results/frequency", ["a"] * 9,
                                                          dtype=text)
        yield "unknown status", lambda f: f["results/status"].write_direct(
            numpy.full(9, 7, dtype=f["results/status"].dtype))
        yield "many statuses", lambda f: f.attrs.__setitem__("points", 10 ** 12)
        yield "negative points", lambda f: f.attrs.__setitem__("points", -1)
        yield "a list for a number", lambda f: f.attrs.__setitem__(
            "points", numpy.arange(1000, dtype="i8"))
        yield "a number for a text", lambda f: f.attrs.__setitem__("format_version", 1.0)
        yield "lists of histories", lambda f: self.replace(
            f, "histories/time", numpy.array([[1.0, 2.0]]), **chunked)
        yield "short histories", lambda f: self.replace(
            f, "histories/tip_deflection", numpy.ones((9, 2)), **chunked)
        yield "short trajectories", lambda f: self.replace(
            f, "particles/point_000003/position/value", numpy.ones((3, 2, 3)), **chunked)
        yield "texts without end", lambda f: self.replace(
            f, "provenance/config", "x" * 50, dtype=text)
        yield "another text", lambda f: self.replace(
            f, "provenance/identity", numpy.bytes_("study.seed = 2\n"))
        yield "no texts", lambda f: f.__delitem__("provenance")
        yield "no head", lambda f: f.__delitem__("h5md")

        def announce(f):
            del f["results/frequency"]
            f.create_dataset("results/frequency", (1 << 40,), "f8", chunks=(1024,),
                             fletcher32=True).attrs["unit"] = "Hz"
        yield "a terabyte", announce

        def link_outside(f):
            del f["results/frequency"]
            f["results/frequency"] = h5py.ExternalLink("/work.h5", "/x")
        yield "external link", link_outside

        def external_storage(f):
            del f["results/frequency"]
            f.create_dataset("results/frequency", (9,), "f8",
                             external=[("/etc/hostname", 0, 72)]).attrs["unit"] = "Hz"
        yield "external storage", external_storage

        def virtual(f):
            del f["results/frequency"]
            layout = h5py.VirtualLayout((9,), "f8")
            layout[:] = h5py.VirtualSource("other.h5", "x", (9,))
            f.create_virtual_dataset("results/frequency", layout).attrs["unit"] = "Hz"
        yield "virtual storage", virtual

    def test_are_refused_by_every_command_that_reads_them(self):
        import h5py
        import shutil
        for name, alter in self.alterations():
            with self.subTest(name):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                shutil.copytree(self.folder / "whole", self.folder / "out")
                with h5py.File(self.folder / "out/study.h5", "r+") as file:
                    alter(file)
                codes = []
                for command in (["archive", "verify", "out"], ["reduce", "out", "--keep"],
                                ["archive", "merge", "out", "-o", "again"]):
                    shutil.rmtree(self.folder / "again", ignore_errors=True)
                    finished = self.culm(*command)
                    self.assertIn(finished.returncode, (DONE, BAD_INPUT, POINTS_FAILED),
                                  f"{command}: {finished.stderr}")
                    self.assertNotIn("internal error", finished.stderr)
                    codes.append(finished.returncode)
                self.assertTrue(any(code != DONE for code in codes), f"no command failed: {codes}")


if __name__ == "__main__":
    unittest.main()
