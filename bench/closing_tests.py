#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's closing test for several stems, and its regressions with smaller pull and tolerance:
closing_tests.py BUILD SCRATCH. Prints Markdown tables.
"""
import json
import subprocess
import sys
from pathlib import Path

from time_steps import ROOT, run, with_key

STEMS = ((113.1, -0.64), (80.0, -0.42), (80.0, -0.15), (150.0, -0.70))  # Hz, b1 per cycle


def line(law: dict) -> str:
    return f"{law['slope']:.2f} and {law['intercept']:.2f}"


def errors(build: Path, study: Path, frequency: float, decay: float) -> tuple[str, str]:
    """Errors of the stem that is simulated with the law that the F-tests kept, in per cent."""
    printed = subprocess.run(
        [build / "src/cli/culm", "simulate", "--via", study, "--frequency-hz", str(frequency),
         "--decay-per-cycle", str(decay), "--json", "-"], text=True, capture_output=True,
        check=True).stdout
    found = json.loads(printed)[-1]
    return f"{found['frequency_error_percent']:.2f}", f"{found['decay_error_percent']:.2f}"


def main(build: Path, scratch: Path):
    published = (ROOT / "config" / "schramm2019.toml").read_text("utf-8")
    studies = {
        "published design": published,
        "tip_deflection_mm = 0.15": with_key(published, "tip_deflection_mm", "0.15"),
        "relative_tolerance = 1e-9": published.replace(
            'method = "implicit"', 'method = "implicit"\nrelative_tolerance = 1e-9'),
        "β 80 … 120 in steps of 10": with_key(published, "bond_damping",
                                              "{ from = 80, to = 120, step = 10 }")}
    print("Lines\n\n| study | √Y in Pa: slope and intercept | β: slope and intercept |\n|---|---|---|")
    for number, (what, text) in enumerate(studies.items()):
        _, summary = run(build, scratch, f"closing{number}", text)
        laws = summary["regression"]
        print(f"| {what} | {line(laws['sqrt_youngs_modulus'])} | {line(laws['bond_damping'])} |")
    print("\nClosing tests\n\n| b2, b1 asked for | study | error of b2, % | error of b1, % |\n|---|---|---|---|")
    for frequency, decay in STEMS:
        row = errors(build, scratch / "closing0", frequency, decay)
        print(f"| {frequency:g} Hz, {decay:.2f} | published design | {' | '.join(row)} |")
    row = errors(build, scratch / "closing3", 80.0, -0.42)
    print(f"| 80 Hz, -0.42 | β 80 … 120 in steps of 10, else the same | {' | '.join(row)} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
