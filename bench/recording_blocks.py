# SPDX-License-Identifier: BSD-3-Clause
"""The blocks of numbers on single recordings: the library on known ones, real ones, the division of
the chain, and stems of a population."""
from __future__ import annotations

from block import block, origin, table
from published_blocks import rows_of, selected, tables, texts_of

AT_THE_NOISE = 1.1  # residual over noise at which a model counts as one that explains a recording


@block("effects-found", "effect-matrix")
def effects_found(result: dict) -> str:
    return table(("recording", "effect", "residual over noise without", "with", "its parameter",
                  "value (95 %)", "truth"),
                 ((row["recording"], row["effect"], f"{row['residual/noise without']:.2f}",
                   f"{row['with']:.2f}", row["parameter"], row["value (95 %)"], row["truth"])
                  for row in rows_of(result, "Found")))


def residual(cell) -> float | None:
    text = str(cell).rstrip("b")
    return None if text == "-" else float(text)


def reaches_noise(cell) -> bool:
    value = residual(cell)
    return value is not None and value < AT_THE_NOISE


def residual_text(cell) -> str:
    text = f"{cell:.2f}" if isinstance(cell, float) else str(cell)
    return f"**{text}**" if reaches_noise(cell) else text


@block("effect-matrix", "effect-matrix")
def effect_matrix(result: dict) -> str:
    rows = [row | {"effect": row["effect"].replace(",", ", ")} for row in rows_of(result, "Matrix")]
    recordings = [name for name in rows[0] if name not in ("table", "effect")]
    reached = []
    for recording, hidden in {row["recording"]: row["effect"]
                              for row in rows_of(result, "Found")}.items():
        names = [row["effect"].replace(", ", " with ") for row in rows
                 if row["effect"] not in (hidden, "none") and reaches_noise(row[recording])]
        if names:
            reached.append(f"{recording}: {', '.join(f'`{name}`' for name in names)}")
    lines = table(("effect", *recordings),
                  ((row["effect"], *(residual_text(row[name]) for name in recordings))
                   for row in rows))
    return (f"{lines}\n\nBold: at most {AT_THE_NOISE} times the noise. Models other than the truth "
            f"that reach it: {'; '.join(reached)}.\n\n{origin(result)}")


tables("strip", "real-recordings", title="Strip")


@block("beam", "real-recordings")
def beam(result: dict) -> str:
    mass = next(text for text in texts_of(result) if text.startswith("Hidden mass"))
    return f"{selected(result, title='Beam')}\n\n{mass}."


tables("spheres", "spheres")


@block("single-modes", "population")
def single_modes(result: dict) -> str:
    texts = [text for text in texts_of(result) if text.startswith(("Correlation", "Within"))]
    return f"{selected(result, title='Eq. 1')}\n\n{' '.join(texts)}\n\n{origin(result)}"


@block("population", "population")
def population(result: dict) -> str:
    inadequate = next(text for text in texts_of(result) if text.startswith("Inadequate"))
    return f"{selected(result, title='Chain')}\n\n{inadequate}\n\n{origin(result)}"


tables("spreads", "spreads")


@block("linear-chain", "closing-tests")
def linear_chain(result: dict) -> str:
    return selected(result, title="Lines")


tables("closing-tests", "closing-tests", title="Closing tests")


@block("earlier-recordings", "earlier/real-recordings")
def earlier_recordings(result: dict) -> str:
    return "\n".join(f"* {case['text'][0].upper()}{case['text'][1:]} (commit {case['commit']})."
                     for case in result["cases"])


def share(value: float, reference: float, digits: int) -> str:
    return f"{100 * (value / reference - 1):+.{digits}f} %"


@block("export-liggghts", "earlier/export-liggghts")
def export_liggghts(result: dict) -> str:
    return (table(("case", "b2 LIGGGHTS / culm, Hz", "difference", "b1 per cycle LIGGGHTS / culm",
                   "difference"),
                  ((case["case"], f"{case['b2 LIGGGHTS']:.5f} / {case['b2 culm']:.5f}",
                    share(case["b2 LIGGGHTS"], case["b2 culm"], 4),
                    f"{case['b1 LIGGGHTS']:.7f} / {case['b1 culm']:.7f}",
                    share(case["b1 LIGGGHTS"], case["b1 culm"], 4)) for case in result["cases"]))
            + f"\n\n{by_hand(result)}")


@block("export-lammps", "earlier/export-lammps")
def export_lammps(result: dict) -> str:
    rows = [case for case in result["cases"] if "text" not in case]
    note = next(case["text"] for case in result["cases"] if "text" in case)
    return (table(("β", "b1 in 1/s, LAMMPS / culm", "b2 in Hz, LAMMPS / culm"),
                  ((case["β"], f"{case['b1 LAMMPS']:.6f} / {case['b1 culm']:.6f}",
                    f"{case['b2 LAMMPS']:.6f} / {case['b2 culm']:.6f}") for case in rows))
            + f"\n\n{note}\n\n{by_hand(result)}")


def by_hand(result: dict) -> str:
    return (f"Computed by hand on {result['date']} ({result['command']}), with earlier versions; no "
            "command repeats it.")
