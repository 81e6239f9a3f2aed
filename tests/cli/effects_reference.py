#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints the library of effects as Markdown, from --json: effects_reference.py CULM.

docs/effects.md contains what it prints; `cli.effects` among the tests compares.
"""

import json
import subprocess
import sys


def number(value: float) -> str:
    return f"{value:.12g}"


def row(parameter: dict) -> str:
    fitted = "known, not fitted" if not parameter["calibrated"] else (
        "fitted" if parameter["fitted_as"] == "as it is" else f"fitted {parameter['fitted_as']}")
    numbers = " | ".join(number(parameter[key]) for key in ("default", "lower", "upper"))
    return (f"| `{parameter['name']}` | {parameter['unit'] or 1} | {numbers} | {fitted} | "
            f"{parameter['meaning']} |\n")


def card(effect: dict) -> str:
    text = f"### `{effect['name']}`\n{effect['summary']}.\n\n"
    for key in ("family", "law", "source", "signature", "remedy", "energy"):
        text += f"* {key.capitalize()}: {effect[key]}.\n"
    if effect["dimensions"] == 3:
        text += "* Needs three dimensions.\n"
    if effect["excludes"]:
        text += f"* Contains {', '.join(effect['excludes'])}, which cannot be added as well.\n"
    return (text + "\n| parameter | unit | default | from | to | in a fit | meaning |\n"
            "|---|---|---|---|---|---|---|\n" + "".join(map(row, effect["parameters"])))


def reference(program: str) -> str:
    printed = subprocess.run([program, "effects", "--json", "-"], text=True, capture_output=True,
                             check=True).stdout
    return "\n".join(map(card, json.loads(printed)["effects"]))


if __name__ == "__main__":
    print(reference(sys.argv[1]), end="")
