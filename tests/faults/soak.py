#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Disturbs random small studies by kills, stop signals, full disks, torn and zero-filled journals
for some minutes, and checks every promise after every disturbance.

soak.py --minutes 10 --seed 1

Each round makes a study of random kind, size and storage, computes it once undisturbed, then in
another folder with disturbances until it is complete. After each disturbance every committed
point must exist (except those whose records the round has damaged), none twice, and every file must
be readable. At the end of a round the archive must be whole and its data equal to those of the
undisturbed run byte for byte. Full disks need the right to mount a small tmpfs; without it the size
of files is limited. Prints one line a round and a summary; exit code 1 at the first violation.
"""

import argparse
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from fault_study import (DONE, HUNG_LAUNCHERS, PATIENCE, POINTS_FAILED, STOPPED_EARLY, ranks_of,
                         committed_points, culm, end_in_order, kill, kill_at_random, start, verify)
from kill_study import Violation, contents, end_with, require

RESUME = ("--resume", "--crash-limit", "0")


def random_study(chance: random.Random) -> str:
    """A study of 12 to 48 points, explicit, implicit or of time steps; some points have no fit."""
    if chance.random() < 0.15:
        return f"""
[study]
kind = "timestep"
seed = {chance.randrange(1000)}
[stem]
spheres = {chance.choice([6, 8])}
length_mm = 155.65
[timestep]
limit_tolerance = 0.05
[factors]
bond_damping = [1, 3, 9, 27]
bond_youngs_modulus_gpa = [1, 2, 4, 8]
"""
    store = chance.choice(["fit", "tip", "heights", "full"])
    damping = sorted(chance.sample([2, 5, 10, 20, 40, 80, 160, 30000], chance.randint(2, 4)))
    heights = "heights_mm = [50, 100]\n" if store in ("heights", "full") else ""
    return f"""
[study]
store = "{store}"
seed = {chance.randrange(1000)}
{heights}[stem]
spheres = {chance.choice([15, 25, 40])}
length_mm = 155.65
[vibration]
duration_s = 0.05
sample_interval_s = {chance.choice(["1e-4", "2e-4", "5e-4"])}
[archive]
trajectory_compression = {chance.choice([0, 3])}
[factors]
bond_damping = {damping}
bond_youngs_modulus_gpa = {sorted(chance.sample(range(1, 20), chance.randint(6, 12)))}
"""


class Disk:
    """A tmpfs whose size can be reduced, or an ordinary folder without the right to mount one."""

    def __init__(self, folder: Path):
        self.folder = folder
        folder.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", "size=200m", "tmpfs", str(folder)]
        self.is_mounted = os.geteuid() == 0 and subprocess.run(
            command, check=False, capture_output=True).returncode == 0

    def resize(self, size: str):
        subprocess.run(["mount", "-o", f"remount,size={size}", str(self.folder)], check=True)

    def used_kilobytes(self) -> int:
        return sum(file.stat().st_blocks for file in self.folder.rglob("*") if file.is_file()) // 2

    def close(self):
        if self.is_mounted:
            subprocess.run(["umount", "-l", str(self.folder)], check=True)


class Round:
    """One study, from its first point to its archive."""

    def __init__(self, disk: Disk, chance: random.Random, counts: Counter):
        self.disk, self.chance, self.counts = disk, chance, counts
        self.folder = disk.folder
        self.committed: set[int] = set()
        (self.folder / "s.toml").write_text(random_study(chance), encoding="utf-8")

    def check(self):
        """Every committed point must exist once and be readable."""
        found = verify(self.folder, "out")
        after = committed_points(self.folder, "out")
        require(self.committed <= after,
                f"points {sorted(self.committed - after)} were committed and are lost")
        require(found.get("repeated_outcomes", 0) == 0, "a point has two outcomes")
        require(not found.get("problems"), f"files cannot be read: {found.get('problems')}")
        self.committed = after

    def killed(self):
        ranks = self.chance.choice([1, 2, 3, 4])
        job = start(self.folder, "run", "s.toml", "-o", "out", "-q", *RESUME, ranks=ranks)
        kind = kill_at_random(job, self.chance, ranks, self.chance.expovariate(1.0 / 0.4))
        self.counts["undisturbed runs" if kind == "ended" else f"kills of one {kind}"] += 1

    def stopped(self):
        ranks = self.chance.choice([1, 2, 3])
        # TERM makes mpirun kill its ranks after a while, which is also a disturbance.
        number = self.chance.choice([signal.SIGUSR1, signal.SIGUSR2, signal.SIGTERM, signal.SIGINT])
        job = start(self.folder, "run", "s.toml", "-o", "out", "-q", *RESUME, ranks=ranks)
        try:
            job.wait(timeout=self.chance.expovariate(1.0 / 0.4))
            return
        except subprocess.TimeoutExpired:
            pass
        workers = ranks_of(job.pid) if ranks > 1 else []
        job.send_signal(number)
        try:
            end_in_order(job, workers)
        except (AssertionError, subprocess.TimeoutExpired):
            for process in [*workers, job.pid]:
                kill(process)
            raise Violation(f"{signal.Signals(number).name} did not end the run") from None
        early = job.returncode < 0 and ranks == 1  # before the handlers are installed
        require(ranks > 1 or early or job.returncode in (DONE, POINTS_FAILED, STOPPED_EARLY),
                f"{signal.Signals(number).name}: exit code {job.returncode}")
        self.counts["stop signals"] += 1

    def full(self):
        """Runs with free space for a few kilobytes, then removes the limit."""
        room = self.chance.choice([4, 20, 60, 200])
        limit = {}
        if self.disk.is_mounted:
            self.disk.resize(f"{self.disk.used_kilobytes() + room}k")
        else:
            size = room * 1024
            limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))}
        command = start(self.folder, "run", "s.toml", "-o", "out", "-q", *RESUME,
                        ranks=1) if not limit else subprocess.Popen(
            [os.environ["CULM_PROGRAM"], "run", "s.toml", "-o", "out", "-q", *RESUME],
            cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **limit)
        command.wait(timeout=PATIENCE)
        if self.disk.is_mounted:
            self.disk.resize("200m")
        require(command.returncode in (DONE, POINTS_FAILED, STOPPED_EARLY),
                f"a full disk ended the run with {command.returncode}")
        self.counts["full disks" if command.returncode == STOPPED_EARLY else
                    "disks that sufficed"] += 1

    def torn(self):
        """Removes the tail of a journal or fills it with zeros, as in the crash of a node."""
        journals = [file for file in self.folder.glob("out/journal/*.culmj")
                    if file.stat().st_size > 2000]
        if not journals:
            return
        journal = self.chance.choice(journals)
        content = journal.read_bytes()
        cut = self.chance.randrange(1, min(len(content) - 1500, 6000))
        zeros = self.chance.choice([0, 512, 4096])
        journal.write_bytes(content[:-cut] + bytes(zeros))
        self.committed = committed_points(self.folder, "out")  # without the removed points
        self.counts["torn journals"] += 1

    def finish(self):
        self.check()
        finished = culm(self.folder, "run", "s.toml", "-o", "out", "-q", *RESUME,
                        ranks=self.chance.choice([1, 2, 4]))
        require(finished.returncode in (DONE, POINTS_FAILED), f"resume failed: {finished.stderr}")
        self.check()
        found = verify(self.folder, "out")
        require(found["exit_code"] == DONE and found["is_whole"], "the archive is not whole")
        require(contents(self.folder, "out") == self.expected,
                "the archive differs from that of an undisturbed run")
        self.counts["points"] += found["points"]["total"]

    def run(self):
        whole = culm(self.folder, "run", "s.toml", "-o", "whole", "-q")
        require(whole.returncode in (DONE, POINTS_FAILED), f"undisturbed: {whole.stderr}")
        self.expected = contents(self.folder, "whole")
        disturbances = [self.killed, self.killed, self.stopped, self.full, self.torn]
        for _ in range(self.chance.randint(2, 8)):
            self.chance.choice(disturbances)()
            self.check()
        self.finish()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    counts: Counter = Counter()
    started = time.monotonic()
    rounds = 0
    with tempfile.TemporaryDirectory(prefix="culm-soak-") as place:
        while time.monotonic() - started < 60.0 * arguments.minutes:
            chance = random.Random(f"{arguments.seed} {rounds}")
            disk = Disk(Path(place) / f"round-{rounds}")
            try:
                Round(disk, chance, counts).run()
            except BaseException:
                kept = Path(tempfile.mkdtemp(prefix="culm-soak-kept-")) / "round"
                shutil.copytree(disk.folder, kept)
                print(f"round {rounds}: what it left is in {kept}", file=sys.stderr)
                raise
            finally:
                disk.close()
            rounds += 1
            print(f"round {rounds}: {dict(counts)}", flush=True)
            shutil.rmtree(disk.folder)
    minutes = (time.monotonic() - started) / 60.0
    counts["launchers that hung after their ranks had ended"] = len(HUNG_LAUNCHERS)
    facts = ", ".join(f"{count} {what}" for what, count in sorted(counts.items()))
    print(f"{rounds} rounds in {minutes:.1f} minutes: {facts}; 0 committed points lost, 0 twice, "
          "every file readable, every archive identical to its undisturbed run")
    return 0


if __name__ == "__main__":
    end_with(main)
