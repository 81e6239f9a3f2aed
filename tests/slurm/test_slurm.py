# SPDX-License-Identifier: BSD-3-Clause
"""Studies in a real Slurm: the walltime, requeue, pre-emption, scancel, job arrays, srun.

Exit code 77, with the reason, if Slurm cannot be started."""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from private_slurm import PrivateSlurm, Unavailable

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "cli"))
from culm_program import DONE, PROGRAM, QUICK, SLOWNESS, CulmTest  # noqa: E402

ROOT = HERE.parent.parent
SKIPPED = 77
# Seconds after which a job is taken to hang; far longer than it takes on a busy machine.
PATIENCE = 300 * SLOWNESS

# 1440 points, 180 batches of 8 lanes: some 17 s on one core, more than two can compute in 5 s.
LONG = """
[study]
name = "long study"
[stem]
spheres = 56
[integrator]
relative_tolerance = 1e-7
[vibration]
duration_s = 0.4
sample_interval_s = 2e-4
[factors]
bond_damping = { from = 5, to = 90, count = 30 }
bond_youngs_modulus_gpa = { from = 1, to = 9, count = 48 }
"""
POINTS = 1440
FIRST_TWO_SHORT = "$((${SLURM_RESTART_COUNT:-0} < 2 ? 6 : 600))"
ENDED = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT")

slurm: PrivateSlurm


class SlurmTest(CulmTest):
    def setUp(self):
        super().setUp()
        # Users may give such a name to a folder.
        self.folder = self.folder / "it's a \"study\"; $(touch hacked)\n#SBATCH --hold"
        self.folder.mkdir()
        self.addCleanup(slurm.run, "scancel", "--user", str(os.getuid()))

    def culm(self, *arguments, **options) -> subprocess.CompletedProcess:
        """Like CulmTest.culm, with more time, because these studies take longer than most."""
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, text=True,
                              capture_output=True, timeout=PATIENCE, check=False, **options)

    def script(self, study: str, ranks: int = 2, **changes) -> str:
        """Writes jobs/slurm/doe.sbatch for the study, on two nodes, with changed variables."""
        text = (ROOT / "jobs/slurm/doe.sbatch").read_text(encoding="utf-8")
        lines = {"#SBATCH --nodes": 2, "#SBATCH --ntasks-per-node": ranks,
                 "CULM_ROOT": shlex.quote(str(ROOT)), "CULM": shlex.quote(PROGRAM),
                 "STUDY": shlex.quote(study), "OUTPUT": "out"} | changes
        for name, value in lines.items():
            text, count = re.subn(f"(?m)^{name}=.*$", lambda _, line=f"{name}={value}": line, text)
            self.assertEqual(count, 1, name)
        return self.write("job.sbatch", text)

    def submit(self, *arguments, **options) -> str:
        """Submits a job; returns its number."""
        answer = slurm.run("sbatch", "--parsable", *arguments, **({"cwd": self.folder} | options))
        self.assertEqual(answer.returncode, 0, answer.stderr)
        return answer.stdout.strip()

    def states(self, job: str) -> list[str]:
        answer = slurm.run("squeue", "--noheader", "--jobs", job, "--states=all",
                           "--format=%T %r %i")
        return answer.stdout.splitlines()

    def wait_for_end(self, job: str):
        """Waits for the end of a job. A requeued job would start after two minutes; here it starts
        after some seconds. Without this delay its old credential, which was revoked, would be
        mistaken for the new one."""
        deadline = time.monotonic() + PATIENCE
        requeued_at = 0.0
        while time.monotonic() < deadline:
            states = self.states(job)
            has_ended = states and all(state.split()[0] in ENDED for state in states)
            if has_ended and not self.is_between_two_starts():
                return
            for state in states:
                if not state.startswith("PENDING BeginTime"):
                    requeued_at = 0.0
                elif requeued_at == 0.0:
                    requeued_at = time.monotonic()
                elif time.monotonic() > requeued_at + 3:
                    slurm.run("scontrol", "update", f"JobId={state.split()[2]}", "StartTime=now")
            time.sleep(0.5)
        self.fail(f"job {job}: {self.states(job)} after {PATIENCE} s\n{self.log()}")

    def log(self) -> str:
        return "\n".join(log.read_text(encoding="utf-8", errors="replace")
                         for log in sorted(self.folder.glob("*.log")))

    def is_between_two_starts(self) -> bool:
        """Whether a job is being requeued; for some seconds such a job seems to have ended."""
        log = self.log()
        return log.rfind("the job starts again") > log.rfind("this run ends within")

    def restarts(self) -> int:
        return self.log().count("not complete: the job starts again")

    def status(self) -> dict:
        """The points in culm archive status; empty while the files are being created."""
        finished = self.culm("archive", "status", "out", "--json", "-")
        return (json.loads(finished.stdout)["points"] or {}) if finished.returncode == DONE else {}

    def wait_for_completed(self, count: int):
        deadline = time.monotonic() + PATIENCE
        while self.status().get("completed", 0) < count:
            self.assertLess(time.monotonic(), deadline, self.log())
            time.sleep(0.2)

    def assert_same_as_undisturbed_run(self, study: str):
        """Asserts equal fits byte for byte, and that every checksum is right."""
        self.assertEqual(self.fits("out"), self.fits_of_undisturbed_run(study))
        self.assert_exit(self.culm("archive", "verify", "out"), DONE)
        self.assertEqual(list(self.folder.rglob("hacked")), [])
        self.assertEqual(list(self.folder.parent.glob("hacked")), [])


class Walltime(SlurmTest):
    def test_study_longer_than_its_job_is_requeued_until_it_is_complete(self):
        self.write("a 'study'.toml", LONG)
        # The job has a limit of minutes, which is too long for a test; its first two starts
        # therefore get 6 s each.
        job = self.submit(self.script("a 'study'.toml", 1, WALLTIME_S=FIRST_TWO_SHORT))
        self.wait_for_end(job)
        log = self.log()
        self.assertGreaterEqual(self.restarts(), 1, log)
        self.assertEqual(log.count("stopped early before the walltime ends"), self.restarts(), log)
        self.assertEqual(len(list(self.folder.glob("*.log"))), 1, "one job from first to last")
        self.assertTrue(log.rstrip().endswith("exit code 0"), log)
        self.assert_same_as_undisturbed_run("a 'study'.toml")

    def test_time_left_is_asked_of_slurm(self):
        self.write("s.toml", QUICK)
        job = self.submit("--time=2", self.script("s.toml"))
        self.wait_for_end(job)
        self.assertRegex(self.log(), rf"this run ends within 00:0(1:5\d|2:00) \(squeue, job {job}\)")
        self.assertIn("COMPLETED", self.states(job)[0])
        self.assert_same_as_undisturbed_run("s.toml")

    def test_limit_that_is_too_short_for_any_point_ends_the_chain_of_jobs(self):
        self.write("s.toml", QUICK)
        # A run reserves one second for an orderly end.
        job = self.submit(self.script("s.toml", WALLTIME_S="1"))
        self.wait_for_end(job)
        log = self.log()
        self.assertRegex(log, "none of the 9 missing points can be computed in the walltime")
        self.assertTrue(log.rstrip().endswith("exit code 2"), log)
        self.assertIn("FAILED", self.states(job)[0])


class Interrupted(SlurmTest):
    def test_scancel_keeps_what_was_computed_and_ends_the_chain_of_jobs(self):
        self.write("s.toml", LONG)
        job = self.submit(self.script("s.toml"))
        self.wait_for_completed(16)
        slurm.run("scancel", job)
        self.wait_for_end(job)
        self.assertEqual(self.restarts(), 0, self.log())
        self.assertEqual(slurm.run("squeue", "--noheader").stdout, "")
        self.assertIn("CANCELLED", self.states(job)[0])
        kept = self.status()
        self.assertGreaterEqual(kept["completed"], 16)
        self.assertLess(kept["completed"], POINTS)
        # The same script finishes the study when it is submitted again.
        job = self.submit("job.sbatch")
        self.wait_for_end(job)
        self.assertIn("COMPLETED", self.states(job)[0], self.log())
        self.assert_same_as_undisturbed_run("s.toml")

    def test_warning_before_pre_emption_requeues(self):
        self.write("s.toml", LONG)
        job = self.submit(self.script("s.toml"))
        self.wait_for_completed(16)
        slurm.run("scancel", "--batch", "--signal=USR1", job)
        self.wait_for_end(job)
        self.assertEqual(self.restarts(), 1, self.log())
        self.assertIn("exit code 75", self.log())
        self.assertEqual(len(list(self.folder.glob("*.log"))), 1, "one job from first to last")
        self.assertIn("COMPLETED", self.states(job)[0], self.log())
        self.assert_same_as_undisturbed_run("s.toml")


class Launchers(SlurmTest):
    def test_srun_starts_one_farm_of_all_ranks(self):
        if "pmix" not in slurm.run("srun", "--mpi=list").stderr + slurm.run(
                "srun", "--mpi=list").stdout:
            self.skipTest("this Slurm has no PMIx")
        self.write("s.toml", QUICK)
        # Only one node is used, because two nodes on one machine would share PMIx's folder.
        job = self.submit("--nodes=1", "--ntasks=2", "--ntasks-per-node=2",
                          self.script("s.toml", LAUNCHER="(srun --mpi=pmix)"))
        self.wait_for_end(job)
        self.assertIn("on 2 ranks", self.log())
        self.assert_same_as_undisturbed_run("s.toml")


class Arrays(SlurmTest):
    def test_diagnosis_has_one_element_for_each_measurement(self):
        measurements = self.folder / "my measurements"
        for name in ("T2-quadratic_drag", "T3-clamp_compliance"):
            shutil.copytree(ROOT / "tests/data/hidden-effect" / name, measurements / name)
        text = (ROOT / "jobs/slurm/diagnosis.sbatch").read_text(encoding="utf-8")
        self.assertIn("\nOPTIONS=()", text)
        # One candidate and a coarse chain suffice, because only the array is tested.
        self.write("d.sbatch", text.replace(
            "\nOPTIONS=()", "\nOPTIONS=(--candidates quadratic_drag --spheres 12)"))
        environment = slurm.environment | {
            "CULM_ROOT": str(ROOT), "CULM": PROGRAM, "MEASUREMENTS": str(measurements),
            "OUTPUT": str(self.folder / "diagnoses")}
        answer = subprocess.run(["sbatch", "--parsable", "--array=0-2", "d.sbatch"],
                                env=environment, cwd=self.folder, text=True, capture_output=True,
                                check=True)
        job = answer.stdout.strip()
        self.wait_for_end(job)
        for name in ("T2-quadratic_drag", "T3-clamp_compliance"):
            self.assertTrue((self.folder / "diagnoses" / name / "complete").exists(), self.log())
            self.assertTrue(list((self.folder / "diagnoses" / name).glob("*.json")), self.log())
        self.assertIn("element 2: there are only 2 measurements", self.log())


    def test_four_jobs_share_a_study_whose_parts_merge_to_the_whole(self):
        self.write("s.toml", QUICK)
        environment = slurm.environment | {
            "CULM_ROOT": str(ROOT), "CULM": PROGRAM, "STUDY": str(self.folder / "s.toml"),
            "OUTPUT": str(self.folder / "parts")}
        script = self.write("p.sbatch", (ROOT / "jobs/slurm/parts.sbatch").read_text("utf-8")
                            .replace("--ntasks-per-node=4", "--ntasks-per-node=1"))
        answer = subprocess.run(["sbatch", "--parsable", "--array=1-4", script],
                                env=environment, cwd=self.folder, text=True, capture_output=True,
                                check=True)
        self.wait_for_end(answer.stdout.strip())
        self.assertEqual(self.log().count("is complete in"), 4, self.log())
        parts = [f"parts/{number}" for number in range(1, 5)]
        merged = self.culm("archive", "merge", *parts, "-o", "out")
        self.assertEqual(merged.returncode, DONE, merged.stderr)
        self.assertIn("9 points: 9 completed, 0 failed, 0 missing", merged.stdout)
        self.assertEqual(self.culm("reduce", "out").returncode, DONE)
        self.assert_same_as_undisturbed_run("s.toml")


class Scripts(SlurmTest):
    def test_are_accepted_from_jobs_slurm(self):
        scripts = sorted((ROOT / "jobs/slurm").glob("*.sbatch"))
        self.assertGreaterEqual(len(scripts), 6)
        for script in scripts:
            answer = slurm.run("sbatch", "--test-only", str(script), cwd=ROOT)
            self.assertEqual(answer.returncode, 0, f"{script}: {answer.stderr}")
            self.assertIn("to start at", answer.stderr)

    def test_archive_and_reduce_leaves_a_verified_archive_with_its_tables(self):
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        text = (ROOT / "jobs/slurm/archive-and-reduce.sbatch").read_text(encoding="utf-8")
        line = next(line for line in text.splitlines() if line.startswith("FOLDERS="))
        text = text.replace(line, 'FOLDERS=("$SLURM_SUBMIT_DIR/out")')
        windows = next(line for line in text.splitlines() if line.startswith("WINDOWS="))
        self.write("a.sbatch", text.replace(windows, "WINDOWS=(0.02)"))
        environment = slurm.environment | {"CULM_ROOT": str(ROOT), "CULM": PROGRAM,
                                           "ARCHIVE": str(self.folder / "kept")}
        job = subprocess.run(["sbatch", "--parsable", "a.sbatch"], env=environment,
                             cwd=self.folder, text=True, capture_output=True,
                             check=True).stdout.strip()
        self.wait_for_end(job)
        self.assertIn("COMPLETED", self.states(job)[0], self.log())
        for name in ("study.h5", "study.h5.sha256", "summary-0.02.json"):
            self.assertTrue((self.folder / "kept" / name).exists(), name)
        self.assertEqual((self.folder / "kept/fits.csv").read_bytes(),
                         (self.folder / "out/fits.csv").read_bytes())


def main():
    global slurm  # pylint: disable=global-statement
    # SIGTERM stops the daemons by KeyboardInterrupt; unittest reports other exceptions as failures.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with tempfile.TemporaryDirectory(prefix="culm-slurm-", ignore_cleanup_errors=True) as place:
        slurm = PrivateSlurm(Path(place))
        try:
            slurm.start()
            result = unittest.main(exit=False).result
        except Unavailable as error:
            print(f"skipped, no Slurm can be started here: {error}")
            sys.exit(SKIPPED)
        finally:
            slurm.stop()
    sys.exit(not result.wasSuccessful())


if __name__ == "__main__":
    main()
