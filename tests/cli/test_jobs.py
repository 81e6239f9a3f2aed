# SPDX-License-Identifier: BSD-3-Clause
"""culm jobs and the loop in its scripts, with substitutes for the commands of batch systems.

tests/slurm runs such scripts in a real Slurm."""

import os
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PATIENCE, QUICK, STOPPED_EARLY, CulmTest

ROOT = Path(__file__).resolve().parent.parent.parent
NASTY = "it's \"a\"; $(touch hacked) `touch hacked`\n#SBATCH --hold\n#PBS -h\ntouch hacked #"

# Writes its arguments, then ends with the next exit code in the file "codes" or repeats the last.
PROGRAM_OF_CODES = """#!/bin/bash
echo "$*" >>calls
code=$(head -n 1 codes)
[[ $(wc -l <codes) -le 1 ]] || sed -i 1d codes
exit "$code"
"""

# Waits for USR1 and then ends like culm.
PROGRAM_THAT_WAITS = """#!/bin/bash
echo "$*" >>calls
trap 'echo USR1 >>calls; exit 75' USR1
touch waiting
for ((k = 0; k < 600; k++)); do sleep 0.1; done
"""


class Loop(CulmTest):
    """run_until_complete of jobs/run-until-complete.sh."""

    def setUp(self):
        super().setUp()
        (self.folder / "bin").mkdir()
        for name in ("qsub", "sbatch"):
            self.executable(f"bin/{name}", f'#!/bin/bash\necho "{name} $*" >>submissions\n')
        self.executable("bin/scontrol", "#!/bin/bash\nexit 1\n")
        self.write("job.sh", 'set -u\n. "$LOOP"\n'
                             'run_until_complete "$LIMIT" ./program one "two 3"\n')

    def executable(self, name: str, text: str):
        self.write(name, text)
        (self.folder / name).chmod(0o755)

    def environment(self, **variables) -> dict[str, str]:
        clean = {name: value for name, value in os.environ.items()
                 if not name.startswith(("SLURM_", "PBS_", "CULM_"))}
        return clean | {"PATH": f"{self.folder}/bin:{os.environ['PATH']}", "LIMIT": "1000",
                        "LOOP": str(ROOT / "jobs/run-until-complete.sh")} | variables

    def run_job(self, codes: list[int], **variables) -> int:
        self.executable("program", PROGRAM_OF_CODES)
        self.write("codes", "".join(f"{code}\n" for code in codes))
        return subprocess.run(["bash", "job.sh"], cwd=self.folder, timeout=PATIENCE, check=False,
                              env=self.environment(**variables)).returncode

    def lines(self, name: str) -> list[str]:
        file = self.folder / name
        return file.read_text(encoding="utf-8").splitlines() if file.exists() else []

    def test_ends_with_a_complete_study(self):
        for code in (0, 3):
            self.assertEqual(self.run_job([code], PBS_JOBID="1"), code)
        self.assertEqual(self.lines("submissions"), [])

    def test_gives_the_time_that_is_left(self):
        self.run_job([0])
        self.assertRegex(self.lines("calls")[0], r"^one two 3 --walltime (1000|99\d)s$")

    def test_leaves_the_time_to_the_batch_system_without_a_limit(self):
        self.run_job([0], LIMIT="0")
        self.assertEqual(self.lines("calls"), ["one two 3"])

    def test_submits_a_pbs_job_again_and_counts(self):
        self.assertEqual(self.run_job([75], PBS_JOBID="1.s"), 0)
        self.assertEqual(self.run_job([75], PBS_JOBID="1.s", CULM_RESTARTS="6"), 0)
        self.assertEqual(self.lines("submissions"), ["qsub -v CULM_RESTARTS=1 job.sh",
                                                     "qsub -v CULM_RESTARTS=7 job.sh"])

    def test_submits_a_new_slurm_job_where_requeue_is_not_allowed(self):
        self.assertEqual(self.run_job([75], SLURM_JOB_ID="7"), 0)
        self.assertEqual(self.lines("submissions"), ["sbatch job.sh"])

    def test_does_not_start_again_without_end(self):
        self.assertEqual(self.run_job([75], PBS_JOBID="1", CULM_RESTARTS="1000"), STOPPED_EARLY)
        self.assertEqual(self.run_job([75], SLURM_JOB_ID="1", SLURM_RESTART_COUNT="3",
                                      CULM_MAX_RESTARTS="3"), STOPPED_EARLY)
        self.assertEqual(self.lines("submissions"), [])

    def test_does_not_repeat_bad_input_or_a_missing_program(self):
        for code in (2, 126, 127):
            self.assertEqual(self.run_job([code], PBS_JOBID="1"), code)
        self.assertEqual(len(self.lines("calls")), 3)
        self.assertEqual(self.lines("submissions"), [])

    def test_continues_at_once_when_a_process_died(self):
        self.assertEqual(self.run_job([139, 137, 1, 0], PBS_JOBID="1"), DONE)
        self.assertEqual(len(self.lines("calls")), 4)

    def test_gives_up_when_processes_die_again_and_again(self):
        self.assertEqual(self.run_job([139], PBS_JOBID="1"), 139)
        self.assertEqual(len(self.lines("calls")), 7)
        self.assertEqual(self.lines("submissions"), [])

    def test_starts_again_when_too_little_time_is_left_after_a_death(self):
        self.assertEqual(self.run_job([139, BAD_INPUT], PBS_JOBID="1"), 0)
        self.assertEqual(self.lines("submissions"), ["qsub -v CULM_RESTARTS=1 job.sh"])

    def signalled(self, number: int) -> int:
        """Exit code of a PBS job that gets a signal while its program works."""
        self.executable("program", PROGRAM_THAT_WAITS)
        process = subprocess.Popen(["bash", "job.sh"], cwd=self.folder,
                                   env=self.environment(PBS_JOBID="1"))
        self.addCleanup(self.end, process)
        deadline = time.monotonic() + PATIENCE
        while not (self.folder / "waiting").exists():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        process.send_signal(number)
        process.communicate(timeout=PATIENCE)
        self.assertEqual(self.lines("calls")[-1], "USR1")
        return process.returncode

    def test_passes_a_warning_on_and_starts_again(self):
        self.assertEqual(self.signalled(signal.SIGUSR1), 0)
        self.assertEqual(len(self.lines("submissions")), 1)

    def test_passes_a_cancellation_on_and_does_not_start_again(self):
        self.assertEqual(self.signalled(signal.SIGTERM), STOPPED_EARLY)
        self.assertEqual(self.lines("submissions"), [])


class Scripts(CulmTest):
    def test_are_sound_in_the_jobs_folder(self):
        scripts = [*(ROOT / "jobs/slurm").glob("*.sbatch"), *(ROOT / "jobs/pbs").glob("*.pbs"),
                   *(ROOT / "jobs").glob("*.sh")]
        self.assertGreaterEqual(len(scripts), 14)
        self.assert_sound(scripts)

    def assert_sound(self, scripts):
        for script in scripts:
            finished = subprocess.run(["bash", "-n", script], capture_output=True, text=True,
                                      check=False)
            self.assertEqual(finished.stderr, "", script)
        if shutil.which("shellcheck"):
            finished = subprocess.run(["shellcheck", "-x", *scripts], cwd=ROOT, text=True,
                                      capture_output=True, check=False)
            self.assertEqual(finished.stdout, "")

    def test_contain_hostile_names_as_words_only(self):
        place = self.folder / NASTY
        place.mkdir()
        (place / "s.toml").write_text(QUICK, encoding="utf-8")
        for system in ("slurm", "pbs"):
            script = self.folder / f"job-{system}"
            self.assert_exit(self.culm("jobs", system, f"{NASTY}/s.toml", "--nodes", "1",
                                       "--ranks-per-node", "1", "--study-output",
                                       f"{NASTY}/out {system}", "-o", script), DONE)
            self.assert_sound([script])
            text = script.read_text(encoding="utf-8")
            for line in text.splitlines():
                self.assertNotRegex(line, r"^#SBATCH --hold|^#PBS -h")
            # Runs without mpirun, as if a batch system had started it.
            script.write_text(text.replace("LAUNCHER=(mpirun) ", "LAUNCHER=() "), encoding="utf-8")
            self.assertNotEqual(script.read_text(encoding="utf-8"), text)
            environment = {name: value for name, value in os.environ.items()
                           if not name.startswith(("SLURM_", "PBS_"))}
            finished = subprocess.run(["bash", script], cwd=self.folder, text=True,
                                      capture_output=True, timeout=PATIENCE, check=False,
                                      env=environment | {"PBS_O_WORKDIR": str(self.folder)})
            self.assert_exit(finished, DONE)
            self.assertTrue((place / f"out {system}" / "study.h5").exists())
        self.assertEqual(list(self.folder.rglob("hacked")), [])


class Sizes(CulmTest):
    def jobs(self, *options):
        return self.culm("jobs", "slurm", "s.toml", "--nodes", "3", "--ranks-per-node", "4",
                         *options)

    def test_come_from_the_cost_model_and_are_reported(self):
        self.write("s.toml", QUICK)
        finished = self.jobs()
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stderr, r"^9 points to compute, [\d.e-]+ core seconds on the "
                         r"reference machine \(nothing has been timed here yet\)\n"
                         r"\d+ ranks? on 1 node: about 00:00:01 of computing, ")
        self.assertIn("12 ranks were asked for; there is work for ", finished.stderr)
        self.assertIn("#SBATCH --time=00:05:00\n", finished.stdout)
        self.assertIn("# 9 points to compute, ", finished.stdout)

    def test_of_a_laboratory_come_from_its_recordings(self):
        for name in ("A", "B", "C"):
            self.copy_recording(ROOT / "tests/data/measurements/T1-null", f"lab/{name}", name)
        finished = self.culm("jobs", "slurm", "lab", "--nodes", "1", "--ranks-per-node", "2")
        self.assert_exit(finished, DONE)
        self.assertRegex(finished.stderr, r"^3 stems to compute, [\d.]+ core seconds on ")
        self.assertIn(f"MEASUREMENTS=({self.folder.resolve()}/lab)\n", finished.stdout)
        self.assertIn("lab-diagnosis\n", finished.stdout)
        self.assert_refused(self.culm("jobs", "slurm", "nowhere", "--nodes", "1"),
                            "culm: nowhere: there is no such folder\n")

    def test_count_only_what_is_missing_and_use_the_pace_of_earlier_runs(self):
        text = QUICK.replace("[5, 10, 15]", "{ from = 5, to = 90, count = 2000 }").replace(
            "duration_s = 0.05", "duration_s = 0.5")
        self.write("s.toml", text)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q", "--walltime", "3s"),
                         STOPPED_EARLY)
        finished = self.jobs("--study-output", "out")
        self.assert_exit(finished, DONE)
        missing = int(finished.stderr.split()[0])
        self.assertLess(missing, 6000)
        self.assertGreater(missing, 0)
        self.assertIn("core seconds at the pace of this study's runs so far\n", finished.stderr)

    def test_are_refused_for_a_complete_study(self):
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        self.assert_refused(self.jobs("--study-output", "out"),
                            "culm: out: the study is complete; there is nothing to compute\n")

    def test_are_refused_for_another_study_in_the_folder(self):
        self.write("s.toml", QUICK)
        self.assert_exit(self.culm("run", "s.toml", "-o", "out", "-q"), DONE)
        self.write("s.toml", QUICK.replace("spheres = 15", "spheres = 14"))
        self.assert_refused(self.jobs("--study-output", "out"),
                            "culm: out holds another study; choose another folder with "
                            "--study-output\n")

    def test_are_refused_with_names_that_could_carry_directives(self):
        self.write("s.toml", QUICK)
        self.assert_refused(self.jobs("--partition", "a\n#SBATCH --hold"),
                            "culm: --partition: $'a\\012#SBATCH --hold' is not a name that a batch "
                            "system accepts; allowed are letters, digits and _ . - + @ ,\n")
        self.assert_refused(self.jobs("--walltime", "12"),
                            'culm: --walltime: "12" is not a duration above zero and of at most a '
                            "year; allowed are HH:MM:SS, MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a "
                            "number with its unit: 90s, 45min, 12h, 2d\n")


if __name__ == "__main__":
    unittest.main()
