#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Disturbs the diagnosis of a laboratory at random, resumes it, and checks that nothing was lost.

kill_laboratory.py RECORDING --kills 20 --seed 1

A disturbance is a kill of one rank or of the whole job, a stop signal, a full disk (a limit on the
size of files), or a cut or zero-filled tail of the file of kept fits. A kill must never lose a
fit. The resumed diagnosis must equal an undisturbed one; only its provenance may differ.
Prints one line for each diagnosis and a summary; exit code 1 at the first violation.
"""

import argparse
import json
import os
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import tempfile
import zlib
from collections import Counter
from pathlib import Path

from fault_study import (BAD_INPUT, DONE, MAGIC, PATIENCE, STOPPED_EARLY, command, culm,
                         kill_at_random, start)
from kill_study import end_with, require

OPTIONS = ("diagnose", "A", "B", "--spheres", "12", "--window", "0.2", "--candidates",
           "quadratic_drag,viscous_drag", "-q")
KEPT = "unfinished.culmj"


def copy_stems(recording: Path, folder: Path):
    """Two stems of one rig with the same readings."""
    for name in ("A", "B"):
        shutil.copytree(recording, folder / name)
        stem = folder / name / "stem.toml"
        text = stem.read_text(encoding="utf-8")
        stem.write_text(re.sub(r'(?m)^id = ".*"$', f'id = "{name}"\nrig = "1"', text, count=1),
                        encoding="utf-8")


def kept_bytes(folder: Path, name: str) -> int:
    kept = folder / name / KEPT
    return kept.stat().st_size if kept.exists() else 0


def is_finished(folder: Path, name: str) -> bool:
    """Whether the document exists and the kept fits are deleted, which a kill may separate."""
    return (folder / name / "laboratory.json").exists() and kept_bytes(folder, name) == 0


def result(folder: Path, name: str) -> dict:
    """The document of a diagnosis without the provenance, which states time, host and ranks."""
    found = json.loads((folder / name / "laboratory.json").read_text(encoding="utf-8"))
    found.pop("provenance")
    return found


def stop(process: subprocess.Popen, chance: random.Random) -> str:
    """Sends a stop signal at a random moment; returns the kind of disturbance."""
    try:
        process.wait(timeout=chance.expovariate(1.0))
        return "ended"
    except subprocess.TimeoutExpired:
        process.send_signal(chance.choice([signal.SIGINT, signal.SIGTERM]))
    process.wait(timeout=PATIENCE)
    return "ended" if process.returncode == DONE else "signal"


def fill_disk(folder: Path, arguments: list[str], size: int, has_begun: bool) -> str:
    """Runs with a limit on the size of every file; culm ignores SIGXFSZ, as a full disk sends none."""
    finished = subprocess.run(
        command(1, *arguments), cwd=folder, text=True, capture_output=True, timeout=PATIENCE,
        check=False, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
    # A disk that is full before anything was computed is refused like any unwritable folder.
    expected = (DONE, STOPPED_EARLY) if has_begun else (DONE, STOPPED_EARLY, BAD_INPUT)
    require(finished.returncode in expected,
            f"a limit of {size} bytes ended with {finished.returncode}: {finished.stderr}")
    return "ended" if finished.returncode == DONE else "full disk"


def header_bytes(kept: Path) -> int:
    """Size of the header: magic, version, length, identity, checksum (docs/archive-format.md)."""
    return 20 + struct.unpack_from("<Q", kept.read_bytes(), 12)[0] + 4


def kept_fits(folder: Path, name: str) -> int:
    """The number of intact records from the beginning of the file on. Its size says less: a cut or
    zero-filled tail counts in it until the next run cuts it off."""
    kept = folder / name / KEPT
    content = kept.read_bytes() if kept.exists() else b""
    if len(content) < 20:
        return 0
    place = header_bytes(kept)
    number = 0
    while content[place:place + 8] == MAGIC:
        size, _, _, _, crc = struct.unpack_from("<QqIII", content, place + 8)
        if zlib.crc32(content[place + 40:place + 40 + size]) != crc:
            break
        place += 40 + size
        number += 1
    return number


def tear(kept: Path, chance: random.Random) -> bool:
    """Cuts the last kept fits, or fills them with zeros, as a power cut may."""
    content = kept.read_bytes()
    lost = min(chance.randrange(1, 5000), len(content) - header_bytes(kept))
    if lost <= 0:
        return False
    tail = bytes(lost) if chance.random() < 0.5 else b""
    kept.write_bytes(content[:-lost] + tail)
    return True


def disturb_once(folder: Path, name: str, chance: random.Random) -> str:
    arguments = [*OPTIONS, "-o", name, "--resume"]
    before = kept_bytes(folder, name)
    fits_before = kept_fits(folder, name)
    kind = chance.choices(["kill", "signal", "full disk", "torn"], weights=[6, 2, 1, 1])[0]
    if kind == "torn":
        torn = before > 0 and tear(folder / name / KEPT, chance)
        return kind if torn else "too early"
    if kind == "full disk":
        return fill_disk(folder, arguments, before + chance.randrange(20_000), before > 0)
    if kind == "signal":
        kind = stop(start(folder, *arguments, ranks=1), chance)
    else:
        ranks = chance.choice([1, 1, 2, 3])
        kind = kill_at_random(start(folder, *arguments, ranks=ranks), chance, ranks,
                              chance.expovariate(1.0))
    finished = is_finished(folder, name)
    require(finished or kept_fits(folder, name) >= fits_before, "kept fits are lost")
    return "ended" if finished else kind


def disturb(folder: Path, name: str, chance: random.Random, seen: Counter, wanted: int):
    """Disturbs a diagnosis until it is complete, at most ten times; then completes it."""
    mine: Counter = Counter()
    while sum(mine.values()) < 10 and sum(seen.values()) + sum(mine.values()) < wanted:
        kind = disturb_once(folder, name, chance)
        if kind == "ended":
            break
        if kind != "too early":
            mine[kind] += 1
    seen.update(mine)
    if not is_finished(folder, name):
        finished = culm(folder, *OPTIONS, "-o", name, "--resume", ranks=chance.choice([1, 2]))
        require(finished.returncode == DONE, f"resume failed: {finished.stderr}")
    files = sorted(os.listdir(folder / name))
    require(files == ["laboratory.json"], f"files of a finished diagnosis: {files}")
    print(f"{name}: {dict(mine)}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path, help="measurement folder, used for both stems")
    parser.add_argument("--kills", type=int, default=20, help="number of disturbances")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    seen: Counter = Counter()
    diagnoses = 0
    with tempfile.TemporaryDirectory(prefix="culm-laboratory-") as place:
        folder = Path(place)
        copy_stems(arguments.recording, folder)
        require(culm(folder, *OPTIONS, "-o", "undisturbed").returncode == DONE,
                "the undisturbed diagnosis failed")
        expected = result(folder, "undisturbed")
        while sum(seen.values()) < arguments.kills:
            name = f"diagnosis-{diagnoses}"
            disturb(folder, name, chance, seen, arguments.kills)
            require(result(folder, name) == expected,
                    f"{name} differs from the undisturbed diagnosis")
            diagnoses += 1
            shutil.rmtree(folder / name)
    print(f"{dict(seen)} over {diagnoses} diagnoses: no kept fit lost, results identical")
    return 0


if __name__ == "__main__":
    end_with(main)
