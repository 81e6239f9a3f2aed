#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The largest explicit step under both laws, its law in β, and the errors of b1 and b2 below it, as
Markdown tables: time_steps.py BUILD SCRATCH.

The errors are those of config/timestep.toml with one Young's modulus, on which they do not depend,
and three shares of the limit.
"""
from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "postprocess"))

import culm  # noqa: E402


def with_key(text: str, key: str, value: str) -> str:
    """The study with another value of a key that it has."""
    changed, count = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
    if count != 1:
        raise SystemExit(f"the study has {count} keys {key}")
    return changed


def run(build: Path, scratch: Path, name: str, text: str):
    """The table of points and the summary of a study."""
    (scratch / f"{name}.toml").write_text(text, "utf-8")
    launch = ["mpirun", "--oversubscribe", "--allow-run-as-root", "-n", "2"]
    subprocess.run([*launch, build / "src/cli/culm", "run", f"{name}.toml", "-o", name, "--quiet"],
                   cwd=scratch, check=True, capture_output=True)
    return (culm.Study(scratch / name).table(),
            json.loads((scratch / name / "summary.json").read_text("utf-8")))


def row(*cells):
    print("| " + " | ".join(map(str, cells)) + " |")


def header(title: str, *names: str):
    print(f"\n{title}:\n")
    row(*names)
    row(*("---:" for _ in names))


def print_limits(tables: dict):
    header("Limits", "β", *(f"{law}: {what}" for law in tables
                            for what in ("bisected/τ", "linearised/τ", "limited by",
                                         "rule / bisected")))
    modulus = "bond_youngs_modulus_gpa"
    of_first = {law: table[table[modulus] == table[modulus].min()] for law, table in tables.items()}
    for k, damping in enumerate(next(iter(of_first.values()))["bond_damping"]):
        cells = []
        for table in of_first.values():
            point = table.iloc[k]
            linearised = min(point["limit_axial"], point["limit_transverse"])
            bisected = 0.5 * (point["limit_stable"] + point["limit_unstable"])
            cells += [f"{bisected / point['bond_time']:.5f}",
                      f"{linearised / point['bond_time']:.5f}",
                      "axial" if point["limit_axial"] <= point["limit_transverse"] else
                      "transverse", f"{point['limit_rule'] / bisected:.3f}"]
        row(f"{damping:g}", *cells)


def print_laws(summaries: dict):
    header("Laws of the limit", "study", "A", "B", "largest residual, %", "a", "b",
           "of the rule's form, %")
    for name, summary in summaries.items():
        cells = []
        for form in ("damped_oscillator", "rule_form"):
            law = summary["regression"][form]
            cells += [f"{each['coefficient']:.4f}" for each in law["coefficients"]]
            cells.append(f"{100.0 * law['largest_residual']:.2f}")
        row(name, *cells)


def print_errors(table, summary, fractions):
    header("Errors", "β", *(f"{quantity} at {share:g}" for share in fractions
                            for quantity in ("b1", "b2")))
    for _, point in table.iterrows():
        cells = []
        for share in fractions:
            for name in ("decay_per_cycle", "frequency"):
                # culm's own reference: the implicit run at a tolerance of 1e-9.
                reference = point[f"reference_{name}"]
                cells.append(f"{abs(point[f'{name}_at_{share:g}'] / reference - 1.0):.1e}")
        row(f"{point['bond_damping']:g}", *cells)
    agreement = summary["implicit_against_converged"]
    print(f"\nThe implicit runs agree with steps extrapolated to zero within "
          f"{agreement['decay']['largest']:.1e} in b1 and "
          f"{agreement['frequency']['largest']:.1e} in b2.")


def main() -> int:
    build, scratch = Path(sys.argv[1]), Path(sys.argv[2])
    limits = (ROOT / "config/timestep-consistent.toml").read_text("utf-8")
    tables, summaries = {}, {}
    for law in ("schramm2019", "consistent"):
        text = limits.replace('name = "consistent"', f'name = "{law}"')
        tables[law], summaries[law] = run(build, scratch, law, text)
    print_limits(tables)
    print_laws(summaries)
    fractions = (0.25, 0.5, 0.95)
    text = (ROOT / "config/timestep.toml").read_text("utf-8")
    text = with_key(text, "bond_youngs_modulus_gpa", "[1]")
    text = with_key(text, "fractions", str(list(fractions)))
    print_errors(*run(build, scratch, "errors", text), fractions)
    return 0


if __name__ == "__main__":
    sys.exit(main())
