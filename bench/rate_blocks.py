# SPDX-License-Identifier: BSD-3-Clause
"""How often diagnoses and intervals are right, as blocks of Markdown.

A recording counts as one with an effect only if the effect is material: it explains more than a
fifth of the noise. The upper bound of an error rate is that of Clopper and Pearson (1934), 95 % on
one side: the largest p for which k errors or fewer in n have a probability of 5 %.
"""
from __future__ import annotations

import math
from collections import Counter
from functools import partial
from statistics import median

from block import Read, block, origin, table

GRADES = {"right": "right", "tie": "tied", "partly": "one of two", "silent": "silent",
          "unknown": "unknown", "wrong": "wrong", "failed": "failed"}
KINDS = {"null": "nothing", "single": "one effect", "pair": "two effects",
         "known_mass": "one effect, and a recording with a known mass",
         "unknown": "a law outside the library", "correlated": "noise correlated by 0.9"}
VISIBLE = 1.5  # rms with the effect over the noise, from which it should be named


# The newest file of a measurement before bench/publish.sh.
EARLIER = {"diagnosis": "diagnosis-judging-12001d3", "rig-effects": "rig-effects-64aeec0",
           "intervals": "intervals-5e304a9", "flawed-noise": "flawed-noise-5e304a9",
           "late-starts": "late-starts-5e304a9", "videos": "videos-5e304a9"}
LISTS = {"diagnosis-library-laws-37390c7": "exactly the library's laws",
         "diagnosis-tuning-7304acc": "tuning half",
         "diagnosis-tuning-60-fe29ccb": "tuning half, the first 60",
         "diagnosis-judging-12001d3": "judging half"}


def latest(read: Read, name: str) -> dict | None:
    """This version's file, or that of an earlier version."""
    return read(name) or read(f"earlier/{EARLIER[name]}")


rates = partial(block, find=latest)


def upper_bound(errors: int, cases: int, level: float = 0.05) -> float:
    """Of the error rate, by bisection of the binomial distribution."""
    if errors >= cases:
        return 1.0
    low, high = errors / cases, 1.0
    for _ in range(60):
        p = 0.5 * (low + high)
        below = sum(math.comb(cases, k) * p**k * (1.0 - p)**(cases - k)
                    for k in range(errors + 1))
        low, high = (p, high) if below > level else (low, p)
    return high


def percent(value: float) -> str:
    return f"{100.0 * value:.1f} %"


def has_material(case: dict) -> bool:
    return any(hidden["is_material"] for hidden in case["hidden"])


def group_of(case: dict) -> str:
    """The row of the trust statement to which a case belongs."""
    kind = case["kind"]
    if kind == "correlated":
        return KINDS[kind] + (", one effect" if has_material(case) else ", nothing")
    if kind == "null" or has_material(case):
        return KINDS[kind]
    return "only effects below a fifth of the noise"


def groups(cases: list[dict]) -> dict[str, list[dict]]:
    order = [*KINDS.values(), KINDS["correlated"] + ", one effect",
             KINDS["correlated"] + ", nothing", "only effects below a fifth of the noise"]
    found = {name: [case for case in cases if group_of(case) == name] for name in order}
    return {name: group for name, group in found.items() if group}


@rates("diagnosis-grades", "diagnosis")
def diagnosis_grades(result: dict) -> str:
    """Recordings by what is hidden and how the answer is graded."""
    rows = []
    for name, group in groups(result["cases"]).items():
        grades = Counter(case["grade"] for case in group)
        wrong = grades["wrong"]
        rows.append((name, len(group), *(grades[grade] for grade in GRADES),
                     percent(upper_bound(wrong, len(group)))))
    return (table(("hidden", "cases", *GRADES.values(), "wrong at most"), rows)
            + f"\n\n{origin(result)}")


@block("earlier-versions", *(f"earlier/{file}" for file in LISTS))
def earlier_versions(*results: dict) -> str:
    """Answers of earlier versions to recordings with a material effect, and without one."""
    rows = []
    for result, name in zip(results, LISTS.values()):
        material = [case for case in result["cases"] if has_material(case)]
        without = [case for case in result["cases"] if not has_material(case)]
        grades = Counter(case["grade"] for case in material)
        rows.append((result["commit"], name, len(material), *(grades[grade] for grade in GRADES),
                     f"{sum(case['grade'] == 'wrong' for case in without)} of {len(without)}"))
    return table(("commit", "list", "with an effect", *GRADES.values(),
                  "a wrong name without one"), rows)


@rates("trust", "diagnosis", "intervals", "rig-effects")
def trust(result: dict, calibrations: dict, laboratories: dict) -> str:
    """The sentences of README.md on the diagnosis of one stem."""
    material = [case for case in result["cases"]
                if has_material(case) and case["kind"] != "correlated"]
    without = [case for case in result["cases"] if case["kind"] == "null"]
    grades = Counter(case["grade"] for case in material)
    named = sum(case["grade"] == "wrong" for case in without)
    counts = ", ".join(f"{grades[grade]} {word}" for grade, word in GRADES.items())
    return "\n".join([
        f"* **The diagnosis** was judged{version_of(result)} on new recordings of an independent beam model. "
        f"Of {len(material)} with a hidden effect that explains more than a fifth of the noise the "
        f"answers are: {counts}. Wrong names are at most "
        f"{percent(upper_bound(grades['wrong'], len(material)))} with 95 % confidence. Of "
        f"{len(without)} recordings in which nothing is hidden {named} got a name (at most "
        f"{percent(upper_bound(named, len(without)))}). "
        "[Every kind of recording](docs/diagnosis-rates.md#one-stem).",
        interval_sentence(calibrations),
        *limit_sentences(result["cases"], laboratories)])


def coverage(cases: list[dict], name: str, uncertainty: str) -> float:
    """Share of a parameter's 95 % intervals, by this standard uncertainty, that contain the
    truth."""
    found = [case["parameters"][name] for case in cases]
    return sum(abs(each["value"] - each["truth"]) <= 1.96 * each[uncertainty]
               for each in found) / len(found)


def version_of(result: dict) -> str:
    """Says in a sentence that the numbers are not those of this version."""
    return "" if "machine" in result else f" (commit {result['commit']}, an earlier version)"


def interval_sentence(calibrations: dict) -> str:
    cases = calibrations["cases"]
    shares = [coverage(cases, name, "combined") for name in cases[0]["parameters"]]
    return (f"* **The intervals**: 95 % intervals contained the truth in {percent(min(shares))} to "
            f"{percent(max(shares))} of {len(cases)} calibrations with wrong inputs"
            f"{version_of(calibrations)} "
            "([uncertainty](docs/uncertainty.md#how-far-the-intervals-can-be-trusted)).")


def limit_sentences(cases: list[dict], laboratories: dict) -> list[str]:
    """What is known to be weak."""
    noisy = [case for case in cases if case["kind"] == "correlated"]
    grades = Counter(case["grade"] for case in noisy)
    answers = ", ".join(f"{grades[grade]} {word}" for grade, word in GRADES.items()
                        if grades[grade])
    own = [(stem["own"], stem["named"]) for case in laboratories["cases"]
           for stem in case["stems"]]
    given = sum(bool(named) for _, named in own)
    have = sum(bool(truth) for truth, _ in own)
    wrong = next((line.rsplit(": ", 1)[1] for line in laboratories["summary"]
                  if line.startswith("wrong among the stems")), "")
    return ([f"* **Noise correlated by 0.9** from frame to frame: {answers} of {len(noisy)}."]
            if noisy else []) + [
        f"* **Effects of stems in laboratories**: {have} stems have an own effect, "
        f"{given} got one; wrong among these: {wrong}{version_of(laboratories)} "
        "([laboratories](docs/diagnosis-rates.md#laboratories))."]


def rate(hits: int, of: int) -> str:
    return f"{hits} of {of}" + (f" ({100.0 * hits / of:.0f} %)" if of else "")


@rates("diagnosis-quantities", "diagnosis")
def diagnosis_quantities(result: dict) -> str:
    cases = result["cases"]
    inside = [case for case in cases if case["kind"] != "unknown"]
    visible = [hidden for case in inside for hidden in case["hidden"]
               if hidden["is_material"] and math.hypot(1.0, hidden["over_noise"]) >= VISIBLE]
    outside = [case for case in cases if case["kind"] == "unknown"]
    sizes = [size for case in cases for size in case["sizes"]]
    told = [explanation for case in inside for explanation in case["explanations"]]
    sure = [is_truth for probability, is_truth in told if probability >= 0.95]
    scored = [case for case in inside if case["explanations"]]
    brier = sum((probability - is_truth)**2 for case in scored
                for probability, is_truth in case["explanations"]) / max(1, len(scored))
    seconds = [case["seconds"] for case in cases]
    rows = [
        ("wrong names", rate(sum(case["grade"] == "wrong" for case in cases), len(cases)),
         "1 %"),
        ("the set of explanations contains the truth",
         rate(sum(case["grade"] in ("right", "tie") for case in inside), len(inside)), "95 %"),
        (f"effects with a misfit of at least {VISIBLE} times the noise that are named by law or "
         "family", rate(sum(hidden["is_named"] for hidden in visible), len(visible)), "90 %"),
        ("laws outside the library that are called unknown, or by their family",
         rate(sum(case["grade"] == "right" for case in outside), len(outside)), ""),
        ("without an answer after 400 s",
         rate(sum(case["grade"] == "failed" for case in cases), len(cases)), "0"),
        ("95 % intervals of sizes that contain the truth",
         rate(sum(abs(size["value"] - size["truth"]) <= size["half_width"] for size in sizes),
              len(sizes)), "95 %"),
        ("explanations with a probability of at least 0.95 that are the truth",
         rate(sum(sure), len(sure)), "95 %"),
        ("Brier score of the probabilities", f"{brier:.3f}", ""),
        ("time on one core", f"median {median(seconds):.1f} s, longest {max(seconds):.0f} s", "")]
    return table(("quantity", "result", "target"), rows)


def hidden_text(case: dict) -> str:
    return " + ".join(f"{hidden['effect']} ({hidden['over_noise']:.1f})"
                      for hidden in case["hidden"]) or "nothing"


@rates("diagnosis-failures", "diagnosis")
def diagnosis_failures(result: dict) -> str:
    """Every case that is neither right nor tied nor silent."""
    lines = []
    for grade, word in (("wrong", "Wrong"), ("failed", "No answer"), ("unknown", "Unknown"),
                        ("partly", "One of two")):
        found = [case for case in result["cases"] if case["grade"] == grade]
        texts = [f"{KINDS[case['kind']]} {case['number']}: {hidden_text(case)}"
                 + (f" as {' or '.join(case['candidates'])}" if grade == "wrong" else "")
                 for case in found]
        lines.append(f"* {word} ({len(found)}): {'; '.join(texts) or 'none'}.")
    return "\n".join(lines)


@rates("intervals", "intervals")
def intervals(result: dict) -> str:
    cases = result["cases"]
    rows = [(name, len(cases), *(percent(coverage(cases, name, kind))
                                 for kind in ("combined", "readings")))
            for name in sorted(cases[0]["parameters"])]
    return (table(("parameter", "cases", "covered", "by the noise of the readings alone"), rows)
            + f"\n\n{origin(result)}")


def names_in(named: dict) -> str:
    members = " or ".join(named["members"])
    return f"{named['family']} ({members})" if named["is_open"] else members


def counted(names: list[str]) -> str:
    return "; ".join(f"{name} in {count} stems" for name, count in sorted(Counter(names).items()))


@rates("rig-effects", "rig-effects")
def rig_effects(result: dict) -> str:
    rows = []
    for case in sorted(result["cases"], key=lambda case: case["number"]):
        hidden = [f"{each['effect']} ({each['over_limit']:.2f} limits)"
                  for each in case["hidden_in_rig"]]
        own = counted([name for stem in case["stems"] for name in stem["own"]])
        answer = [f"{names_in(each)} of the rig" for each in case["named"] if each["rig"]]
        found = counted([names_in(each) for stem in case["stems"] for each in stem["named"]])
        rows.append((case["number"], case["stem_count"], "; ".join([*hidden, *filter(None, [own])])
                     or "nothing", case["conclusion"],
                     "; ".join([*answer, *filter(None, [found])]) or "nothing",
                     f"{case['seconds']:.0f}"))
    return "\n".join([table(("", "stems", "hidden", "answer", "named", "s"), rows), "",
                      origin(result)])


@rates("rig-effects-summary", "rig-effects")
def rig_effects_summary(result: dict) -> str:
    return "\n".join(f"* {line}" for line in result["summary"][1:])


@rates("flawed-noise", "flawed-noise")
def flawed_noise(result: dict) -> str:
    line = result["summary"][0]
    return f"{line[0].upper()}{line[1:]}. {origin(result)}"


@rates("late-starts", "late-starts")
def late_starts(result: dict) -> str:
    return f"{result['summary'][0]}. {origin(result)}"


@rates("videos", "videos")
def videos(result: dict) -> str:
    cases = [case for case in result["cases"] if "damping" in case]
    adequate = sum(case["answer"].strip() == "adequate" for case in result["cases"])
    covered = {name: sum(abs(case[name]["error"]) <= 1.96 * case[name]["standard_uncertainty"]
                         for case in cases) for name in ("youngs_modulus", "damping")}
    largest = {name: 100.0 * max(abs(case[name]["trackers_error"]) for case in cases)
               for name in ("youngs_modulus", "damping")}
    pixels = [case["reading_error_px"] for case in cases]
    return (f"Of {len(result['cases'])} rendered videos in which nothing is missing {adequate} are "
            f"adequate. 95 % intervals contain Y in {covered['youngs_modulus']} and β in "
            f"{covered['damping']} of {len(cases)}. With exact inputs Y is off by at most "
            f"{largest['youngs_modulus']:.3f} % and β by {largest['damping']:.3f} %. Readings are "
            f"off by {min(pixels):.3f} to {max(pixels):.3f} pixel (rms). {origin(result)}")
