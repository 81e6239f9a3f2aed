# SPDX-License-Identifier: BSD-3-Clause
"""Small studies that are killed, damaged and resumed; shared by the fault programs."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

# The definitions are shared with the tests of the command line.
sys.path.append(str(Path(__file__).resolve().parent.parent / "cli"))
from culm_program import (BAD_INPUT, DONE, POINTS_FAILED, PROGRAM, SLOWNESS,  # noqa: E402,F401
                          STOPPED_EARLY, contents, ranks_of, journal_bytes, launcher)

# Seconds after which a run is taken to hang: far longer than any of these studies takes.
PATIENCE = 120 * SLOWNESS
# Begins every record of a journal (docs/archive-format.md).
MAGIC = b"\xC5REC\r\n\x1A\xF1"
# mpirun processes that end_in_order had to kill.
HUNG_LAUNCHERS: list[int] = []

# 24 points of some 0.05 s; all histories are stored, so that the archive has every kind of dataset.
STUDY = """
[study]
store = "full"
heights_mm = [50, 100]
[stem]
spheres = 40
length_mm = 155.65
[vibration]
duration_s = 0.05
sample_interval_s = 2e-4
[factors]
bond_damping = [25, 50, 100]
bond_youngs_modulus_gpa = [1, 2, 3, 4, 5, 6, 7, 8]
"""

# The same study with four times the points, which takes long enough to be stopped during the run.
LONG_STUDY = STUDY.replace("[25, 50, 100]", "[10, 20, 25, 30, 40, 50, 60, 70, 80, 90, 100, 110]")


def command(ranks: int, *arguments) -> list[str]:
    """culm on `ranks` ranks; one rank is started without a launcher."""
    return [*(launcher(ranks) if ranks > 1 else []), PROGRAM, *arguments]


def culm(folder: Path, *arguments, ranks: int = 1) -> subprocess.CompletedProcess:
    """Runs culm to its end."""
    # A damaged archive may contain texts that are not UTF-8.
    return subprocess.run(command(ranks, *arguments), cwd=folder, text=True, errors="replace",
                          capture_output=True, timeout=PATIENCE, check=False)


def start(folder: Path, *arguments, ranks: int) -> subprocess.Popen:
    """Begins a run in a new process group, so that all its processes can be killed at once."""
    return subprocess.Popen(command(ranks, *arguments), cwd=folder, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, start_new_session=True)


def verify(folder: Path, study: str) -> dict:
    """The output of culm archive verify for the folder, with its exit code."""
    finished = culm(folder, "archive", "verify", study, "--json", "-")
    if finished.returncode == BAD_INPUT:
        return {"exit_code": BAD_INPUT, "message": finished.stderr}
    return json.loads(finished.stdout) | {"exit_code": finished.returncode}


def committed_points(folder: Path, study: str) -> set[int]:
    """Points with an outcome in the archive or in a journal whose checksums are right."""
    found = verify(folder, study)
    if found["exit_code"] == BAD_INPUT or found["points"] is None:
        return set()
    missing = set(found["missing_points"])
    return {point for point in range(found["points"]["total"]) if point not in missing}


def kill_at_random(process: subprocess.Popen, chance: random.Random, ranks: int,
                   delay: float) -> str:
    """Kills one rank or the whole job with kill -9 after the delay; returns which, or "ended"."""
    try:
        process.wait(timeout=delay)
        return "ended"
    except subprocess.TimeoutExpired:
        pass
    kinds = ["rank"] if ranks > 1 else []
    kind = chance.choice([*kinds, "job"])
    workers = ranks_of(process.pid) if ranks > 1 else []
    if kind == "rank" and workers:
        kill(chance.choice(workers))
    else:
        kind = "job"
        for worker in workers:
            kill(worker)
        kill(process.pid)
    end_in_order(process, workers)
    return kind


def end_in_order(process: subprocess.Popen, workers: list[int]) -> bool:
    """Waits for the ranks, then for their launcher. The launcher of Open MPI 4.1.4 sometimes hangs
    (in PMIx_server_finalize) if ranks die while it starts them; it is then killed, and False is
    returned. Raises AssertionError if a rank does not end, which is a fault of the program."""
    if not workers:
        process.wait(timeout=PATIENCE)
        return True
    wait_for_the_end_of(workers)
    assert not any(map(is_alive, workers)), "a rank did not end"
    try:
        process.wait(timeout=15)
        return True
    except subprocess.TimeoutExpired:
        kill(process.pid)
        process.wait()
        HUNG_LAUNCHERS.append(process.pid)
        return False


def kill(process_id: int):
    try:
        os.kill(process_id, signal.SIGKILL)
    except ProcessLookupError:
        pass


def wait_for_the_end_of(process_ids: list[int]):
    """mpirun gives ranks a second to end; until then their journals are open."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if not any(is_alive(process_id) for process_id in process_ids):
            return
        time.sleep(0.01)


def is_alive(process_id: int) -> bool:
    try:
        text = Path(f"/proc/{process_id}/stat").read_text(encoding="utf-8")
    except OSError:
        return False
    return text.rpartition(")")[2].split()[0] != "Z"
