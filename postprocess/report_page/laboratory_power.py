# SPDX-License-Identifier: BSD-3-Clause
"""The probability of every effect of a rig against the number of stems, and what it says."""
from __future__ import annotations

from itertools import cycle

import numpy as np

from command_results import Laboratory
from palette import BLACK, GREY, ORANGE, SERIES
from report_page.drawing import axis, layout, level, line
from report_page.markup import Plot, Section, shown, table

CERTAIN = 0.95  # Policy::held_probability
MOST_MARKED = 60  # numbers of stems with a mark each
MOST_CURVE_POINTS = 200
NOT_COMPUTED = "not computed"


def counted_stems(count: float) -> str:
    return f"{count:.0f} stem{'' if count == 1 else 's'}"


def probability_text(value: float | None) -> str:
    """Three digits, and never a certainty that no recording gives."""
    if value is None or 5e-4 <= value < 0.9995:
        return shown(value, 3)
    return "< 0.001" if value < 0.5 else "> 0.999"


def of_rig(name: str) -> str:
    return f" of rig {name}" if name else ""


def _power_sentence(effect: dict, count: int) -> str:
    """The use of more stems for the effect; empty if the document does not state it."""
    name = f"{effect['effect']}{of_rig(effect['rig'])}"
    needed, probability = effect["stems_needed"] or 0, effect["probability"] or 0.0
    if needed > 0:
        return f"About {needed:.0f} more stem{'' if needed == 1 else 's'} like these would make " \
               f"{name} certain."
    if probability >= CERTAIN:
        return f"{name} is certain with the {counted_stems(count)}."
    if not _has_power(effect):
        return ""
    if effect["log_odds_per_stem"] <= 0.0:
        return f"More stems like these would not make {name} certain."
    return (f"{name} holds against the likeliest model without it, but all models together give it "
            f"{shown(probability, 2)} only.")


def _has_power(effect: dict) -> bool:
    return effect.get("log_odds") is not None and effect.get("log_odds_per_stem") is not None


def _probabilities(effect: dict, count: int, stems: np.ndarray) -> np.ndarray:
    """The effect's probability with `stems`; each adds as much as the mean of the `count` ones."""
    log_odds = effect["log_odds"] + (stems - count) * effect["log_odds_per_stem"]
    return 1.0 / (1.0 + np.exp(-np.clip(log_odds, -700.0, 700.0)))


def add_power(section: Section, laboratory: Laboratory):
    """The use of more stems for each effect, in sentences, as curves and as a table."""
    effects = [effect for effect in laboratory.content["rig_effects"] if not effect["known"]]
    if not effects:
        return
    section.heading("Probability against the number of stems")
    counts = [sum(stem["rig"] == effect["rig"] for stem in laboratory.stems) for effect in effects]
    for effect, count in zip(effects, counts):
        sentence = _power_sentence(effect, count)
        if sentence:
            section.paragraph(sentence)
    drawn = [pair for pair in zip(effects, counts) if _has_power(pair[0])]
    rows = [[effect["effect"], effect["rig"], count, probability_text(effect["probability"]),
             *([effect["log_odds"], effect["log_odds_per_stem"]] if _has_power(effect)
               else [NOT_COMPUTED] * 2)]
            for effect, count in zip(effects, counts)]
    behind = table(["effect", "rig", "stems now", "probability now", "log odds now",
                    "log odds per stem"], rows)
    if not drawn:
        section.note("The probability against the number of stems was not computed.")
        section.add(behind)
        return
    end = max(int(max(2 * count, count + (effect["stems_needed"] or 0) + 2))
              for effect, count in drawn)
    stems = np.unique(np.linspace(1, end, min(end, MOST_CURVE_POINTS)).round())
    names = [effect["effect"] + of_rig(effect["rig"]) for effect, _ in drawn]
    columns = [_probabilities(effect, count, stems) for effect, count in drawn]
    behind += table(["number of stems", *names],
                    [[int(number), *(float(each) for each in row)]
                     for number, row in zip(stems, zip(*columns))])
    mode = "lines+markers" if end <= MOST_MARKED else "lines"
    traces = []
    looks = zip(cycle((*SERIES, ORANGE, BLACK)), cycle(("solid", "dash", "dot")))
    for name, column, (colour, dash) in zip(names, columns, looks):
        traces.append(line(stems, column, name, colour, dash, mode=mode,
                           marker={"color": colour, "size": 5, "symbol": "circle"}))
    levels = [level(CERTAIN, BLACK, "dash")]
    levels += [level(count, GREY, "solid", "x") for count in sorted({count for _, count in drawn})]
    missing = ", ".join(effect["effect"] for effect in effects if not _has_power(effect))
    section.add_plots([Plot("power", "", "Probability of every effect against the number of stems.",
                            traces, layout(axis("number of stems", whole=True),
                                           axis("probability", range=[0.0, 1.05]), levels=levels),
                            300)],
                      "Probability of the likeliest model with the effect against the likeliest "
                      "without it, if every stem adds as much as the mean stem of these. The grey "
                      f"line is the number of stems now; {shown(CERTAIN)} (dashed) is required. "
                      "The probability in the table above compares all models and can differ."
                      + (f" {NOT_COMPUTED.capitalize()}: {missing}." if missing else ""), behind)
