#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Table of the two regressions for each law, window and treatment of b0.

Reads the JSON summaries that jobs/reproduction.sh writes to a folder, named
<law>-<window in s>-<free|fixed>.json, and prints a Markdown table.
"""

import json
import pathlib
import sys


def rows(folder):
    """One table row per summary: law, window, b0, and both single-predictor laws."""
    for law in ("schramm2019", "consistent"):
        for window in ("0.01", "0.088", "0.1", "0.2"):
            for amplitude in ("free", "fixed"):
                file = folder / f"{law}-{window}-{amplitude}.json"
                regression = json.loads(file.read_text())["regression"]
                root, damping = regression["sqrt_youngs_modulus"], regression["bond_damping"]
                yield (law, window, amplitude, f"{root['slope']:.2f}",
                       f"{root['intercept']:.1f}", f"{root['adjusted_r2']:.5f}",
                       f"{damping['slope']:.2f}", f"{damping['intercept']:.2f}",
                       f"{damping['adjusted_r2']:.5f}")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: reproduction_table.py FOLDER")
    print("| law | window s | b0 | √Y: slope | intercept | adj. R² "
          "| β: slope | intercept | adj. R² |")
    print("|---|---|---|---|---|---|---|---|---|")
    try:
        for row in rows(pathlib.Path(sys.argv[1])):
            print("| " + " | ".join(row) + " |")
    except OSError as error:
        sys.exit(f"reproduction_table.py: {error.filename}: {error.strerror} "
                 "(jobs/reproduction.sh writes these files).")


if __name__ == "__main__":
    main()
