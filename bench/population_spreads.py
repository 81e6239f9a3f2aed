#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The spread of b1 and b2 of config/replicates.toml, and with two other assumptions on modulus and
damping: population_spreads.py BUILD SCRATCH. Prints a Markdown table.
"""
import re
import sys
from pathlib import Path

from time_steps import ROOT, run, with_key

MEASURED = {"frequency": 21.2, "decay_per_cycle": 0.17}  # Schramm et al. (2019), Section 3.1


def without_factor(text: str, key: str) -> str:
    return re.sub(rf"(?m)^{key} = .*\n", "", text)


def variants(text: str) -> dict[str, str]:
    modulus, damping = "bond_youngs_modulus_gpa", "bond_damping"
    constant = without_factor(text, modulus).replace("[stem]\n", f"[stem]\n{modulus} = 3.4\n")
    other = with_key(without_factor(text, damping), modulus,
                     '{ distribution = "lognormal", mean = 3.79, sd = 2.01, min = 0.1, max = 40 }')
    other = other.replace("[factors]\n", f"[factors]\n{damping} = "
                          '{ distribution = "normal", mean = 115.5, sd = 40, min = 10, max = 250 }\n')
    return {"lognormal, 4.1 GPa (3.52): the paper's range; damping 123": text,
            "3.4 GPa and damping 123 for all": constant,
            "lognormal, 3.79 GPa (2.01); damping normal, 115.5 (40)": other}


def main(build: Path, scratch: Path):
    text = (ROOT / "config" / "replicates.toml").read_text("utf-8")
    print("| modulus and damping | sd of b2, Hz | of the measured variance, % | sd of b1 "
          "| of the measured variance of b1, % |\n|---|---|---|---|---|")
    for number, (what, study) in enumerate(variants(text).items()):
        _, summary = run(build, scratch, f"spread{number}", study)
        cells = [what]
        for name, digits in (("frequency", 1), ("decay_per_cycle", 3)):
            spread = summary["population"][name]["standard_deviation"]
            cells += [f"{spread:.{digits}f}", f"{100 * (spread / MEASURED[name])**2:.0f}"]
        print(f"| {' | '.join(cells)} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
