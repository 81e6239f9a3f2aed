# SPDX-License-Identifier: BSD-3-Clause
"""Runs the culm program in an empty folder; shared by the tests of the command line."""

import os
import re
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = os.environ["CULM_PROGRAM"]
# Open MPI refuses to start as root or on more ranks than cores without these variables (PRTE:
# version 5). Other MPIs ignore them.
os.environ |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1",
               "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe"}
# How many times slower the program is than a release build: preset "asan" says 10.
SLOWNESS = float(os.environ.get("CULM_TEST_SLOWNESS", "1"))
# Seconds after which a run is taken to hang: far longer than any of these studies takes.
PATIENCE = 60 * SLOWNESS

DONE, BAD_INPUT, POINTS_FAILED, STOPPED_EARLY = 0, 2, 3, 75

# 9 points of a coarse stem, some 0.2 s of work, 8 kB of history each.
QUICK = """
[stem]
spheres = 15
length_mm = 155.65
[vibration]
duration_s = 0.05
[factors]
bond_damping = [5, 10, 15]
bond_youngs_modulus_gpa = [1, 4, 9]
"""

# 24 points that take some 0.05 s each: time enough to be interrupted.
SLOW = """
[stem]
spheres = 56
[vibration]
duration_s = 0.05
[factors]
bond_damping = [25, 50, 100]
bond_youngs_modulus_gpa = [1, 2, 3, 4, 5, 6, 7, 8]
"""

# The stems with this damping creep back without swinging, so that Eq. 1 cannot be fitted.
OVERDAMPED = QUICK.replace("[5, 10, 15]", "[5, 10, 30000]")

# Text of a study -> its fits.
UNDISTURBED: dict[str, str] = {}


def launcher(ranks: int) -> list[str]:
    """The beginning of a command that starts a program on `ranks` ranks."""
    return [os.environ["CULM_MPIEXEC"], "-n", str(ranks)]


def journal_bytes(study: Path) -> int:
    """Size of the journals of a running study. A study removes its journals when it ends, so a
    listed journal may no longer exist."""
    size = 0
    for journal in study.glob("journal/*.culmj"):
        try:
            size += journal.stat().st_size
        except FileNotFoundError:
            pass
    return size


def contents(folder: Path, study: str) -> dict[str, bytes]:
    """The raw bytes of every dataset except the provenance, which states the time and the host.
    Where a trajectory is stored depends on the rank that computed it."""
    import h5py  # imported here because most tests need no archive
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset) and not name.startswith("provenance"):
            found[name] = item[()].tobytes()

    with h5py.File(folder / study / "study.h5", "r") as file:
        file.visititems(take)
        found.pop("histories/trajectory_place", None)
        for point in file.get("particles", ()):  # links are not visited
            file[f"particles/{point}"].visititems(
                lambda name, item, point=point: take(f"particles/{point}/{name}", item))
    return found


def children_of(process_id: int) -> list[int]:
    """The child processes of a process, from /proc."""
    children = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = stat.read_text(encoding="utf-8")
        except OSError:
            continue  # has ended meanwhile
        if int(text.rpartition(")")[2].split()[1]) == process_id:
            children.append(int(stat.parent.name))
    return children


def ranks_of(process_id: int) -> list[int]:
    """The processes of culm that a launcher started, itself (Open MPI) or by a proxy (MPICH)."""
    ranks = []
    for child in children_of(process_id):
        try:
            program = os.readlink(f"/proc/{child}/exe")
        except OSError:
            continue  # has ended meanwhile
        is_culm = program == str(Path(PROGRAM).resolve())
        ranks += [child] if is_culm else ranks_of(child)
    return ranks


class CulmTest(unittest.TestCase):
    """Every test works in an empty folder, `self.folder`."""

    maxDiff = None

    def setUp(self):
        place = tempfile.TemporaryDirectory(prefix="culm-cli-")
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)

    def write(self, name: str, text: str) -> str:
        (self.folder / name).write_text(text, encoding="utf-8")
        return name

    def copy_recording(self, source: Path, folder: str, name: str, *keys: str):
        """Copies a measurement folder; the copy's id is `name`, and [stem] has these lines too."""
        shutil.copytree(source, self.folder / folder)
        stem = self.folder / folder / "stem.toml"
        text, count = re.subn(r'(?m)^id = ".*"$', "\n".join((f'id = "{name}"', *keys)),
                              stem.read_text("utf-8"), count=1)
        self.assertEqual(count, 1)
        stem.write_text(text, "utf-8")

    def culm(self, *arguments, **options) -> subprocess.CompletedProcess:
        """Runs culm to its end in the test's folder; the options are those of subprocess.run."""
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, text=True,
                              capture_output=True, timeout=PATIENCE, check=False, **options)

    def start(self, *command) -> subprocess.Popen:
        """Begins a run that the test will disturb."""
        process = subprocess.Popen(command, cwd=self.folder, text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        self.addCleanup(self.end, process)
        return process

    @staticmethod
    def end(process: subprocess.Popen):
        if process.poll() is None:
            process.kill()
        process.communicate()

    def wait_for_points(self, folder: str, count: int):
        """Returns when the journals contain `count` points of 1001 samples each."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            if journal_bytes(self.folder / folder) > count * 1001 * 8:
                return
            time.sleep(0.002)
        self.fail(f"{folder}: no {count} points within {PATIENCE} s")

    def assert_exit(self, finished: subprocess.CompletedProcess, code: int):
        self.assertEqual(finished.returncode, code, finished.stdout + finished.stderr)

    def assert_refused(self, finished: subprocess.CompletedProcess, message: str):
        """Asserts that the input is refused with exactly this message and no other output."""
        self.assertEqual(finished.stderr, message)
        self.assertEqual(finished.stdout, "")
        self.assertEqual(finished.returncode, BAD_INPUT)

    def fits(self, folder: str) -> str:
        """All fits of a study with every digit, with the study's options and with others. Equal
        texts mean equal histories."""
        stored = (self.folder / folder / "fits.csv").read_text(encoding="utf-8")
        again = f"{folder}-again"
        shutil.copytree(self.folder / folder, self.folder / again)
        refit = self.culm("reduce", again, "--window", "0.02", "--amplitude", "fixed")
        self.assert_exit(refit, DONE)
        text = (self.folder / again / "fits.csv").read_text(encoding="utf-8")
        self.assertNotEqual(text, stored)
        shutil.rmtree(self.folder / again)
        return stored + text

    def fits_of_undisturbed_run(self, study: str) -> str:
        """The fits of a run on one rank, computed once for all tests of a file."""
        text = (self.folder / study).read_text(encoding="utf-8")
        if text not in UNDISTURBED:
            self.assert_exit(self.culm("run", study, "-o", "undisturbed", "-q"), DONE)
            UNDISTURBED[text] = self.fits("undisturbed")
        return UNDISTURBED[text]
