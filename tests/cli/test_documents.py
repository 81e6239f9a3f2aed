# SPDX-License-Identifier: BSD-3-Clause
"""README.md and docs are correct: their commands run and print the output that is shown."""

import csv
import re
import shutil
import subprocess
import unittest
from pathlib import Path

from culm_program import PROGRAM
from executed_page import ROOT, ExecutedPage
from test_track import PICTURES, VIDEO

DOCS = ROOT / "docs"
BUILDS = "builds or installs culm itself: tests/run.sh and tests/install do"
INSIDE_SLURM = "needs Slurm: tests/slurm submits such scripts"
OUTSIDE_DATA = "the recordings are not part of the repository"
MINUTES = "takes minutes to hours"
# Page -> first line of a block that is not run here -> why not. The names and options of its culm
# commands are still checked.
LEFT_OUT = {
    "README.md": {
        "./jobs/local.sh      # installs packages, builds, runs a study, calibrates a filmed stem, "
        "finds a hidden effect": BUILDS,
        "culm diagnose tests/data/hidden-effect/T2-quadratic_drag -o results/T2":
            "half a minute; cli.tutorial runs it and compares this output with the printed one",
    },
    "CONTRIBUTING.md": {
        "jobs/install-packages.sh build test figures develop   # Debian 12; says what is missing "
        "where it may not install": BUILDS,
        "cmake --preset asan && cmake --build --preset asan && ctest --preset asan": BUILDS,
    },
    "install.md": {
        "jobs/install-packages.sh build run figures": BUILDS,
        "cmake -S . -B build/package -G Ninja -DCULM_ARCHITECTURE=x86-64-v2 "
        "-DCULM_BUILD_TESTS=OFF": BUILDS,
    },
    "cluster.md": {"sbatch study.sbatch": INSIDE_SLURM,
                   "sbatch --array=1-4 jobs/slurm/parts.sbatch": INSIDE_SLURM},
    "laboratory.md": {"mpirun -n 2 culm diagnose LAB -o ALL": MINUTES},
    "real-data.md": {
        "culm fit STRIP --backbone": OUTSIDE_DATA,
        "culm import mapping.toml -o beam": OUTSIDE_DATA,
    },
    "reliability.md": {
        "cmake -S . -B build/fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCULM_FUZZ=ON "
        "&& ninja -C build/fuzz": "fuzzers run for as long as one lets them; ctest -R fuzz replays "
                                  "what they found",
    },
}
# A recording with drag, so that effects added on a page improve the fit.
RECORDING = ROOT / "tests" / "data" / "hidden-effect" / "T2-quadratic_drag"


def excerpt_of_recording(folder: Path):
    """The first frames of every third height; a fit of them takes a fraction of a second."""
    folder.mkdir()
    shutil.copy(RECORDING / "stem.toml", folder)
    settings = (folder / "stem.toml").read_text("utf-8")
    (folder / "stem.toml").write_text(re.sub(r"(?m)^noise_by_height.*\n", "", settings), "utf-8")
    with (RECORDING / "deflection.csv").open(encoding="utf-8") as table:
        rows = [[row[0], *row[1::3]] for row in csv.reader(table)]
    with (folder / "deflection.csv").open("w", encoding="utf-8", newline="") as table:
        csv.writer(table).writerows(rows[:140])


class Reference(ExecutedPage):
    """A page whose commands run in the repository's top folder and write to `results`."""

    is_tutorial = False

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.left_out = LEFT_OUT.get(cls.page.name, {})

    def given(self, folder: Path):
        for part in ("config", "jobs", "postprocess", "tests"):
            (folder / part).symlink_to(ROOT / part)


class Readme(Reference, unittest.TestCase):
    page = ROOT / "README.md"


class FirstStudy(Reference, unittest.TestCase):
    page = DOCS / "first-study.md"


class Backbone(Reference, unittest.TestCase):
    page = DOCS / "backbone.md"


class FirstRecording(Reference, unittest.TestCase):
    page = DOCS / "first-recording.md"


class Configuration(Reference, unittest.TestCase):
    page = DOCS / "config.md"


class Effects(Reference, unittest.TestCase):
    page = DOCS / "effects.md"


class Uncertainty(Reference, unittest.TestCase):
    page = DOCS / "uncertainty.md"


class RealData(Reference, unittest.TestCase):
    page = DOCS / "real-data.md"


class Cluster(Reference, unittest.TestCase):
    page = DOCS / "cluster.md"

    def given(self, folder: Path):
        super().given(folder)
        shutil.copy(ROOT / "config" / "schramm2019-explicit.toml", folder / "STUDY.toml")


class Replicates(Reference, unittest.TestCase):
    page = DOCS / "replicates.md"


class Reproduction(Reference, unittest.TestCase):
    page = DOCS / "reproduction.md"


class OfStudy(Reference):
    """A page about the study results/quick."""

    def given(self, folder: Path):
        super().given(folder)
        subprocess.run([PROGRAM, "run", "config/quick.toml", "-o", "results/quick", "--quiet"],
                       cwd=folder, capture_output=True, check=True)


class Report(OfStudy, unittest.TestCase):
    page = DOCS / "report.md"


class Archive(OfStudy, unittest.TestCase):
    page = DOCS / "archive-format.md"


class OfMeasurements(Reference):
    """A page about two recordings, M and N, which are fitted in a fraction of a second."""

    def given(self, folder: Path):
        super().given(folder)
        excerpt_of_recording(folder / "M")
        shutil.copytree(folder / "M", folder / "N")
        settings = folder / "N" / "stem.toml"
        text = re.sub(r"(?m)^id = .*$", 'id = "N"', settings.read_text("utf-8"))
        settings.write_text(text, "utf-8")


class Calibrate(OfMeasurements, unittest.TestCase):
    page = DOCS / "calibration.md"
    small = {"calibrate": "--spheres 12"}


class Fit(OfMeasurements, unittest.TestCase):
    page = DOCS / "fit-format.md"


class Compare(OfMeasurements, unittest.TestCase):
    page = DOCS / "compare.md"
    small = {"compare": "--spheres 8 --window 0.1"}


class Diagnose(OfMeasurements, unittest.TestCase):
    page = DOCS / "diagnosis.md"
    small = {"diagnose": "--spheres 12"}

    def given(self, folder: Path):
        super().given(folder)
        shutil.copy(ROOT / "config" / "effects" / "any_power_drag.toml", folder / "my_effect.toml")


class Laboratory(OfMeasurements, unittest.TestCase):
    page = DOCS / "laboratory.md"
    small = {"calibrate": "--spheres 12", "diagnose LAB/R01 LAB/R02 -o": "--spheres 12"}

    def given(self, folder: Path):
        super().given(folder)
        for name in ("R01", "R02", "R03"):
            shutil.copytree(ROOT / "tests/data/lab-rig" / name, folder / "LAB" / name)


class Track(Reference, unittest.TestCase):
    page = DOCS / "tracking.md"

    def given(self, folder: Path):
        super().given(folder)
        (folder / "frames").mkdir()
        for number, picture in enumerate(PICTURES):
            (folder / f"frames/{number:03d}.pgm").write_bytes(picture)
        for name in ("VIDEO", "A", "B"):
            text = VIDEO.format(frames="frames", name=name)
            (folder / f"{name}.toml").write_text(text, "utf-8")


EXECUTED = {test.page.name for test in globals().copy().values()
            if isinstance(test, type) and issubclass(test, ExecutedPage) and hasattr(test, "page")
            } | {"howto.md", "python.md", "tutorial-hidden-effect.md"}


if __name__ == "__main__":
    unittest.main()
