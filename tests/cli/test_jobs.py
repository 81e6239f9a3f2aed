# SPDX-License-Identifier: BSD-3-Clause
"""The scripts of jobs/ and their loop, with substitutes for the commands of batch systems.

tests/slurm runs such scripts in a real Slurm."""

import os
import re
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from culm_program import BAD_INPUT, DONE, PATIENCE, PROGRAM, QUICK, STOPPED_EARLY, CulmTest

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
        self.assertGreaterEqual(len(scripts), 16)
        for script in scripts:
            finished = subprocess.run(["bash", "-n", script], capture_output=True, text=True,
                                      check=False)
            self.assertEqual(finished.stderr, "", script)
        if shutil.which("shellcheck"):
            finished = subprocess.run(["shellcheck", "-x", *scripts], cwd=ROOT, text=True,
                                      capture_output=True, check=False)
            self.assertEqual(finished.stdout, "")

    def run_copy(self, script: str, **variables) -> subprocess.CompletedProcess:
        """Runs a script of jobs/ without mpirun, as if a batch system had started it."""
        text, count = re.subn(r"(?m)^LAUNCHER=\(mpirun\)", "LAUNCHER=()",
                              (ROOT / "jobs" / script).read_text(encoding="utf-8"))
        self.assertEqual(count, 1)
        self.write("job.sh", text)
        environment = {name: value for name, value in os.environ.items()
                       if not name.startswith(("SLURM_", "PBS_", "CULM_"))}
        here = str(self.folder)
        return subprocess.run(["bash", "job.sh"], cwd=here, text=True, capture_output=True,
                              timeout=PATIENCE, check=False,
                              env=environment | {"PBS_O_WORKDIR": here, "SLURM_SUBMIT_DIR": here,
                                                 "CULM_ROOT": str(ROOT), "CULM": PROGRAM}
                              | variables)

    def test_take_hostile_names_as_words(self):
        place = self.folder / NASTY
        place.mkdir()
        (place / "s.toml").write_text(QUICK, encoding="utf-8")
        for script in ("slurm/doe.sbatch", "pbs/doe.pbs"):
            output = place / f"out {script[:3]}"
            self.assert_exit(self.run_copy(script, STUDY=str(place / "s.toml"),
                                           OUTPUT=str(output)), DONE)
            self.assertTrue((output / "study.h5").exists())
        self.assertEqual(list(self.folder.rglob("hacked")), [])

    def test_write_where_they_were_submitted(self):
        for script in ("slurm/doe.sbatch", "pbs/doe.pbs"):
            self.assert_exit(self.run_copy(script, STUDY=str(ROOT / "config/quick.toml")), DONE)
            results = self.folder / "results"
            self.assertTrue((results / "schramm2019/study.h5").exists())
            shutil.rmtree(results)

    def test_diagnose_and_resume_a_laboratory(self):
        self.write("program", PROGRAM_OF_CODES)
        (self.folder / "program").chmod(0o755)
        for script, limit in (("slurm/laboratory.sbatch", ""),
                              ("pbs/laboratory.pbs", r" --walltime 43(200|199|198)s")):
            self.write("codes", "0\n")
            finished = self.run_copy(script, CULM="./program", MEASUREMENTS="my lab")
            self.assert_exit(finished, DONE)
            calls = self.folder / "calls"
            self.assertRegex(calls.read_text(encoding="utf-8"),
                             r"^diagnose my lab -o \S+/results/laboratory --resume --quiet"
                             rf"{limit}\n$")
            calls.unlink()


if __name__ == "__main__":
    unittest.main()
