#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Kills ranks and jobs of small studies at random, resumes, and checks that nothing was lost.

kill_study.py --kills 20 --seed 1 [--method sundials]

After every kill no committed point may be missing, no point may have two outcomes, and every file
must be readable. The tables of a finished study must equal those of an undisturbed run byte for
byte. Prints one line for each study and a summary; exit code 1 at the first violation.
"""

import argparse
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from fault_study import (DONE, STUDY, committed_points, contents, culm, kill_at_random, start,
                         verify)


class Violation(Exception):
    """A promise is broken."""


def require(condition: bool, text: str):
    if not condition:
        raise Violation(text)


def tables(folder: Path, study: str) -> bytes:
    return (folder / study / "fits.csv").read_bytes()


def check_after_kill(folder: Path, study: str, before: set[int]) -> set[int]:
    found = verify(folder, study)
    after = committed_points(folder, study)
    require(before <= after, f"points {sorted(before - after)} were committed and are lost")
    require(found.get("repeated_outcomes", 0) == 0, "a point has two outcomes")
    require(not found.get("problems"), f"files cannot be read: {found.get('problems')}")
    for journal in found.get("journals", []):
        require(journal["skipped_bytes"] == 0 and journal["corrupt_records"] == 0,
                f"damaged journal: {journal}")
    return after


def finish(folder: Path, study: str, ranks: int):
    """Completes the study by --resume."""
    finished = culm(folder, "run", "s.toml", "-o", study, "-q", "--resume", "--crash-limit", "0",
                    ranks=ranks)
    require(finished.returncode == DONE, f"resume failed: {finished.stderr}")


def disturb(folder: Path, study: str, chance: random.Random, kills: Counter, wanted: int) -> int:
    """Kills a study repeatedly until it is complete; returns its number of kills."""
    committed: set[int] = set()
    count = 0
    started = time.monotonic()
    while sum(kills.values()) < wanted:
        ranks = chance.choice([1, 2, 3, 4])
        process = start(folder, "run", "s.toml", "-o", study, "-q", "--resume", "--crash-limit",
                        "0", ranks=ranks)
        # Kills occur between the start, before the first journal exists, and some batches later.
        kind = kill_at_random(process, chance, ranks, chance.expovariate(1.0 / 0.4))
        committed = check_after_kill(folder, study, committed)
        if kind == "ended":
            require(process.returncode == DONE, f"an undisturbed run ended with "
                                                f"{process.returncode}")
            break
        kills[kind] += 1
        count += 1
    finish(folder, study, chance.choice([1, 2, 4]))
    check_after_kill(folder, study, committed)
    require(verify(folder, study)["exit_code"] == DONE, "the finished archive is not whole")
    print(f"{study}: {count} kills in {time.monotonic() - started:.1f} s", flush=True)
    return count


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--method", default="implicit", choices=["implicit", "explicit", "sundials"],
                        help="the integrator")
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    kills: Counter = Counter()
    studies = 0
    with tempfile.TemporaryDirectory(prefix="culm-faults-") as place:
        folder = Path(place)
        (folder / "s.toml").write_text(
            STUDY + f'[integrator]\nmethod = "{arguments.method}"\n', encoding="utf-8")
        require(culm(folder, "run", "s.toml", "-o", "undisturbed", "-q").returncode == DONE,
                "the undisturbed run failed")
        expected = tables(folder, "undisturbed"), contents(folder, "undisturbed")
        while sum(kills.values()) < arguments.kills:
            study = f"study-{studies}"
            disturb(folder, study, chance, kills, arguments.kills)
            require((tables(folder, study), contents(folder, study)) == expected,
                    f"{study}: the tables differ from those of an undisturbed run")
            studies += 1
            shutil.rmtree(folder / study)
    print(f"{kills['rank']} kills of one rank and {kills['job']} of the whole job over {studies} "
          "studies: no committed point lost, none twice, every file readable, tables identical")
    return 0


def end_with(main):
    """Ends the program with the result of main, or with 1 and the sentence of a violation."""
    try:
        sys.exit(main())
    except Violation as violation:
        print(f"VIOLATION: {violation}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    end_with(main)
