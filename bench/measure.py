#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs the measurements of measurements.py whose files in bench/results are not those of the
sources, and writes these files: measure.py BUILD [--seconds S] [--only NAME...] [--list].

A measurement that is stopped by --seconds continues with the next call. A file holds the command,
the commit, the machine, the date, and one line for each case.
"""
from __future__ import annotations

import argparse
import datetime
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measurements import MEASUREMENTS, Measurement

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "bench" / "results"
MANY = 10**6  # s


def git(*words: str) -> str:
    return subprocess.run(["git", "-C", ROOT, *words], text=True, capture_output=True,
                          check=True).stdout.strip()


def changed_since(commit: str, sources: tuple[str, ...]) -> bool:
    """Whether a commit, or the working tree, changed the sources after `commit`; blanks do not
    count."""
    return subprocess.run(["git", "-C", ROOT, "diff", "-w", "--quiet", commit, "--", *sources],
                          capture_output=True, check=False).returncode != 0


def read_result(name: str) -> dict | None:
    file = RESULTS / f"{name}.json"
    return json.loads(file.read_text("utf-8")) if file.is_file() else None


def is_fresh(measurement: Measurement) -> bool:
    found = read_result(measurement.name)
    return found is not None and not changed_since(found["commit"], measurement.sources)


def machine() -> dict:
    facts = dict(re.findall(r"^([^:]+):\s+(.*)$", subprocess.run(
        ["lscpu"], text=True, capture_output=True, check=True,
        env={**os.environ, "LC_ALL": "C"}).stdout, re.M))
    flags = facts.get("Flags", "").split()
    return {"processor": facts.get("Model name", "unknown"), "cores": os.cpu_count(),
            "family": f"{facts.get('CPU family', '?')}, model {facts.get('Model', '?')}",
            "vectors": "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "SSE",
            "load": [round(value, 2) for value in os.getloadavg()]}


def number_of(text: str):
    """A cell as a number where it is one: "1 234", "12.0 %", "1e-07"."""
    plain = re.sub(r"(?<=\d) (?=\d{3}\b)", "", text)
    plain = plain.removesuffix("%").strip()
    try:
        return float(plain) if re.search(r"[.e]", plain) else int(plain)
    except ValueError:
        return text


def table_rows(text: str) -> list[dict]:
    """The rows of all Markdown tables; "table" is the last line of text above the table, and other
    lines of text are rows {"text"}."""
    rows, header, title = [], None, ""
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            header = None
            if line.strip():
                title = line.strip().lstrip("#* ").rstrip(":*")
                rows.append({"text": title})
        elif header is None:
            header = [f"{cell} ({k})" if cell in cells[:k] else cell
                      for k, cell in enumerate(cells)]  # the names may repeat
        elif not set(line) <= set("|-: "):
            rows.append({"table": title} |
                        {key: number_of(cell) for key, cell in zip(header, cells)})
    return rows


class Run:
    """One call of a measurement's command within a limit of time."""

    def __init__(self, measurement: Measurement, build: Path):
        self.measurement, self.build = measurement, build
        self.partial = build / "measured" / f"{measurement.name}.json"
        self.partial.parent.mkdir(parents=True, exist_ok=True)

    def words(self, scratch: str) -> list[str]:
        launch = "mpirun --oversubscribe -n 2"
        if os.geteuid() == 0:
            launch += " --allow-run-as-root"
        return shlex.split(os.path.expandvars(self.measurement.command).format(
            build=self.build, bench=self.build / "bench", launch=launch, scratch=scratch,
            root=ROOT, file=self.partial))

    def drop_stale_cases(self, commit: str):
        """Cases of another commit with the same sources stay, under the commit of the program."""
        if not self.partial.is_file():
            return
        found = json.loads(self.partial.read_text("utf-8"))
        if found["commit"] == commit:
            return
        if changed_since(found["commit"].removesuffix("-dirty"), self.measurement.sources):
            self.partial.unlink()
        else:
            self.partial.write_text(json.dumps(found | {"commit": commit}))

    def outcome(self, seconds: float) -> dict | None:
        """All cases, with the summary that the program prints of them; None if the time did not
        suffice."""
        collects = "{file}" in self.measurement.command
        if collects:
            self.drop_stale_cases(program_commit(self.build))
        with tempfile.TemporaryDirectory() as scratch:
            process = subprocess.Popen(self.words(scratch), text=True, stdout=subprocess.PIPE,
                                       stderr=subprocess.STDOUT, cwd=scratch)
            try:
                printed, _ = process.communicate(timeout=seconds)
            except subprocess.TimeoutExpired:
                process.terminate()
                process.wait()
                return None
        if process.returncode != 0:
            raise SystemExit(f"{shlex.join(self.words('SCRATCH'))}: exit code "
                             f"{process.returncode}\n{printed}")
        if not collects:
            return {"cases": table_rows(printed)}
        return {"summary": summary_of(printed, self.measurement.summary),
                "cases": json.loads(self.partial.read_text("utf-8"))["cases"]}


def summary_of(printed: str, beginning: str) -> list[str]:
    """The lines from the last one with this beginning on."""
    lines = [line for line in printed.splitlines() if line.strip()]
    first = [k for k, line in enumerate(lines) if line.startswith(beginning)]
    return lines[first[-1]:] if beginning and first else []


def program_commit(build: Path) -> str:
    """The commit that the programs of the build were made from."""
    header = build / "bench" / "generated" / "bench_commit.hpp"
    if not header.is_file():
        return ""
    found = re.search(r'commit = "([^"]*)"', header.read_text("utf-8"))
    return found[1] if found else ""


def write_result(measurement: Measurement, outcome: dict):
    head = {"table": measurement.name, "question": measurement.question,
            "command": re.sub(r"\{(\w+)\}", lambda word: word[1].upper(), measurement.command),
            "commit": git("rev-parse", "--short=8", "HEAD"),
            "date": datetime.date.today().isoformat(), "machine": machine()}
    if outcome.get("summary"):
        head["summary"] = outcome["summary"]
    kept = [measurement.keep(case) for case in outcome["cases"]]
    kept.sort(key=lambda case: (str(case.get("kind", "")), case.get("number", 0)))
    lines = ",\n".join("  " + json.dumps(case, ensure_ascii=False) for case in kept)
    text = json.dumps(head, ensure_ascii=False, indent=1)[:-2] + f',\n "cases": [\n{lines}\n ]\n}}\n'
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"{measurement.name}.json").write_text(text, "utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="folder with the programs of bench")
    parser.add_argument("--seconds", type=float, default=MANY, help="stop after this time")
    parser.add_argument("--only", nargs="+", default=[], help="names of measurements")
    parser.add_argument("--list", action="store_true", help="say which files are stale")
    options = parser.parse_args()
    unknown = set(options.only) - {each.name for each in MEASUREMENTS}
    if unknown:
        parser.error(f"{', '.join(sorted(unknown))}: known are "
                     f"{', '.join(each.name for each in MEASUREMENTS)}")
    end = time.monotonic() + options.seconds
    stale = [each for each in MEASUREMENTS if not is_fresh(each)
             and (not options.only or each.name in options.only)]
    if options.list:
        for each in stale:
            print(f"{each.name:20} {each.minutes:5.1f} min: {each.question}")
        print(f"{sum(each.minutes for each in stale):.0f} min are planned for these, "
              f"{sum(each.minutes for each in MEASUREMENTS):.0f} for all measurements")
        return 0
    for each in stale:
        if each.needs and each.needs not in os.environ:
            print(f"{each.name}: left out, because {each.needs} does not name a program")
            continue
        if changed_since("HEAD", each.sources):
            raise SystemExit(f"{each.name}: commit the changes of {' '.join(each.sources)} first")
        built = program_commit(options.build).removesuffix("-dirty")
        compiled = tuple(source for source in each.sources
                         if Path(source).suffix not in (".py", ".sh", ".toml"))
        if built and changed_since(built, compiled):
            raise SystemExit(f"{each.name}: the programs are of {built}: build them first")
        print(f"{each.name}: {each.question}", flush=True)
        outcome = Run(each, options.build.resolve()).outcome(end - time.monotonic())
        if outcome is None:
            print(f"{each.name}: not complete; the same command continues")
            return 75
        write_result(each, outcome)
    return 0


if __name__ == "__main__":
    sys.exit(main())
