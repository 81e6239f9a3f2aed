# SPDX-License-Identifier: BSD-3-Clause
"""The blocks of numbers on time, memory and lost data."""
from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from block import block, origin, table


def rows_of(result: dict, title: str = "") -> list[dict]:
    """The rows of the tables whose title begins so."""
    return [case for case in result["cases"]
            if "table" in case and case["table"].startswith(title)]


def texts_of(result: dict) -> list[str]:
    return [case["text"] for case in result["cases"] if "text" in case]


def selected(result: dict, columns: dict[str, str] | None = None, title: str = "",
             where: Callable[[dict], bool] = lambda row: True) -> str:
    """A table of some columns: {name in the file: name on the page}; None: of all."""
    found = [row for row in rows_of(result, title) if where(row)]
    if columns is None:
        columns = {name: name for name in found[0] if name != "table"}
    return table(columns.values(), ([row.get(key, "") for key in columns] for row in found))


def tables(name: str, file: str, columns: dict[str, str] | None = None, title: str = "",
           where: Callable[[dict], bool] = lambda row: True):
    """Registers a block that is a selection of one file, with its origin."""
    @block(name, file)
    def made(result: dict) -> str:
        return f"{selected(result, columns, title, where)}\n\n{origin(result)}"
    return made


tables("peer-step", "peer-step", {
    "round": "round", "peer, ns": "authors' code, ns", "planar, scalar": "planar, one stem",
    "planar, lanes": "planar, a lane", "spatial, scalar": "spatial, one stem",
    "spatial, lanes": "spatial, a lane", "times faster in space": "times faster in space"})


@block("stems", "stems")
def stems(result: dict) -> str:
    single = [row for row in rows_of(result) if row.get("ratio", "") != ""]
    half = len(single) // 2
    alone, batch = "one stem, ms/cycle", "batch of like stems, ms/cycle and stem"
    head = next(text for text in texts_of(result) if "in the plane" in text)
    return table(("Y, GPa", "β", "steps a cycle", "planar, one stem", "planar, in a batch",
                  "spatial, one stem", "spatial, in a batch"),
                 ((flat["Y/GPa"], flat["β"], flat["steps/cycle"], f"{flat[alone]:.2f}",
                   f"{flat[batch]:.2f}", f"{deep[alone]:.2f}", f"{deep[batch]:.2f}")
                  for flat, deep in zip(single[:half], single[half:]))
                 ) + f"\n\n{head} {origin(result)}"


@block("derivatives", "stems")
def derivatives(result: dict) -> str:
    rows = [row for row in rows_of(result) if "one run" in row]
    costs = [row["a derivative, in runs"] for row in rows]
    errors = [max(row[key] for key in ("d/dY", "d/dβ", "d/dδ")) for row in rows]
    return (f"A derivative costs {min(costs):.2f} to {max(costs):.2f} of a run, for Y 0.4 to 10 GPa "
            f"and β 1 to 200; its largest error is {min(errors):.0e} to {max(errors):.0e} of its "
            "largest value at the default tolerance.")


def number_in(result: dict, beginning: str, pattern: str) -> float:
    """The number that a line of text of the file contains."""
    line = next(text for text in texts_of(result) if text.startswith(beginning))
    return float(re.search(pattern, line)[1])


class Target(NamedTuple):
    what: str
    wanted: str
    reached: str
    verdict: str  # met, missed, not decided


def verdict(is_met: bool) -> str:
    return "met" if is_met else "**missed**"


def at_most(what: str, limit: float, value: float, unit: str, digits: int = 2) -> Target:
    return Target(what, f"≤ {limit:g} {unit}", f"{value:.{digits}f} {unit}",
                  verdict(value <= limit))


def at_least(what: str, limit: float, value: float, unit: str, digits: int = 0) -> Target:
    return Target(what, f"≥ {limit:,.0f} {unit}".replace(",", " "),
                  f"{value:,.{digits}f} {unit}".replace(",", " "), verdict(value >= limit))


def targets_of_runs(explicit_step: dict, implicit: dict) -> list[Target]:
    explicit = {row["variant"]: row["per stem, median"] for row in rows_of(explicit_step)}
    single = [row for row in rows_of(implicit) if row.get("ratio", "") != ""]
    planar = single[:len(single) // 2]
    batch = "batch of like stems, ms/cycle and stem"
    return [at_most("explicit step, planar, in lanes", 1.8, explicit["planar, lanes"], "ns"),
            at_most("explicit step, spatial, in lanes", 5.0, explicit["spatial, lanes"], "ns"),
            at_most("implicit, a planar stem, a cycle, the worst of nine", 3.0,
                    max(row["one stem, ms/cycle"] for row in planar), "ms"),
            at_most("the same in a batch, without the static start", 0.8,
                    max(row[batch] for row in planar), "ms"),
            at_most("a derivative", 0.9, max(row["a derivative, in runs"]
                                             for row in rows_of(implicit)
                                             if "one run" in row), "runs")]


def targets_of_studies(study_methods: dict, large_study: dict) -> list[Target]:
    methods = {row["method"]: row["wall, s"] for row in rows_of(study_methods)}
    large = {row["what"]: row for row in rows_of(large_study)}
    plan = sum(large[name]["processor, s"] for name in ("design, checked at every point",
                                                        "batches, by expected cost"))
    resume = next(row["processor, s"] for name, row in large.items()
                  if name.startswith("resume: what the journals hold"))
    memory = max(row["largest resident set so far, MB"] for row in large.values())
    return [at_most("published study on two cores, all included, wall", 2.5,
                    methods["implicit"], "s"),
            at_most("the same with SUNDIALS", 2.5, methods["arkode"], "s"),
            at_most("a million points: plan", 5.0, plan, "s"),
            at_most("a million points: what a resume adds", 5.0, resume, "s"),
            at_most("a million points: memory, with all statistics", 200.0, memory, "MB", 0)]


def targets_of_farm(farm: dict, many_ranks: dict) -> list[Target]:
    shares = {row["stored"]: row["share"] for row in rows_of(farm, "Share of the archive")}
    ranks = [row["with opening"] for row in rows_of(many_ranks)
             if row["ranks"] == 16384 and row["bound, s"] > 50]
    efficiency = {row["work"]: row for row in rows_of(farm, "Efficiency")}
    words = {"met": "met", "missed": "**missed**"}
    two = [Target(f"two ranks, {name}", "≥ 97 %", row["efficiency"],
                  words.get(row["97 %"], "not decided")) for name, row in efficiency.items()]
    return [*two,
            at_least("trivial points through the scheduler", 2e5,
                     number_in(farm, "through the scheduler:", r": (\d+)"), "points/s"),
            at_least("trivial points to the archive", 2e4,
                     number_in(farm, "to the archive", r"s, (\d+) points/s"), "points/s"),
            at_most("writing, of the wall time, with heights", 5.0, shares["heights"], "%"),
            at_most("writing, with full trajectories", 15.0, shares["full"], "%"),
            at_least("16 384 ranks with 60 s of work each, predicted: the worst of three", 95,
                     min(ranks), "%", 1)]


@block("targets", "explicit-step", "stems", "study-methods", "large-study", "farm", "many-ranks")
def targets(explicit_step: dict, implicit: dict, study_methods: dict, large_study: dict,
            farm: dict, many_ranks: dict) -> str:
    found = (targets_of_runs(explicit_step, implicit)
             + targets_of_studies(study_methods, large_study) + targets_of_farm(farm, many_ranks))
    machine = implicit["machine"]
    return (table(("target", "wanted", "reached", ""), found)
            + f"\n\nOn {machine['processor']}, {machine['vectors']}, {machine['cores']} cores.")


tables("tolerance", "tolerance", {
    "tolerance": "tolerance", "first mode, b1": "first mode: b1", "released, b1": "released: b1",
    "tip": "tip", "ms per cycle": "ms a cycle"},
       where=lambda row: row["tolerance"] in (1e-7, 1e-6, 2e-6, 1e-5))
# Between their relatives in the table.
SIMILAR_METHODS = ("RODAS4P", "RODAS5P", "ARK436L2SA", "QESDIRK436L2SA")
tables("methods", "methods", {"method": "method", "tol": "tolerance", "mean": "mean, ms a cycle",
                              "Y 0.4, β 1": "Y 0.4 GPa, β 1", "Y 1, β 25": "Y 1, β 25",
                              "Y 10, β 200": "Y 10, β 200"},
       where=lambda row: "mean" in row and row["method"] not in SIMILAR_METHODS)
tables("study-methods", "study-methods", {
    "method": "method", "wall, s": "wall, s", "in the map, ms a point": "in the map, ms a point",
    "steps a point": "steps a point", "µs a step": "µs a step"})
tables("study-overhead", "study-overhead", {
    "variant": "variant", "wall": "wall, s", "processor": "processor, s",
    "processor / bare": "processor time over bare", "compute share": "share of the runs, %"})
tables("shares", "farm", {
    "stored": "stored", "wall, s": "wall, s",
    "journals and trajectories, s": "journals and trajectories, s", "study file, s": "study file, s",
    "share": "share, %"}, "Share of the archive")
tables("efficiency", "farm", {
    "work": "work", "independent ranks, s": "independent ranks, s", "efficiency": "efficiency",
    "97 %": "97 %", "busy": "busy, %", "outside the map": "outside the map, %"}, "Efficiency")


@block("trivial-points", "farm")
def trivial_points(result: dict) -> str:
    return "\n".join(f"* {text}" for text in texts_of(result)
                     if text.startswith(("through the scheduler", "to the archive")))


tables("large-study", "large-study", {
    "what": "what", "processor, s": "processor, s", "wall, s": "wall, s",
    "largest resident set so far, MB": "largest resident set so far, MB"},
       where=lambda row: not row["what"].startswith(("open", "batches")))
tables("many-ranks", "many-ranks", {
    "ms a batch": "ms a batch", "ranks": "ranks", "batches a rank": "batches a rank",
    "makespan, s": "time, s", "bound, s": "bound, s", "with opening": "efficiency, %",
    "largest delay, ms": "largest delay, ms"},
       where=lambda row: row["ranks"] > 64 and row["bound, s"] > 50
       or row["ranks"] == 16384 and row["batches a rank"] > 1)
tables("fits", "fits", {"recording": "recording", "stems": "stems", "calibrate, s": "calibrate, s",
                        "diagnose, s": "diagnose, s"})


@block("kills", "kills")
def kills(result: dict) -> str:
    return "\n".join(f"* {text}" for text in texts_of(result)) + f"\n\n{origin(result)}"


tables("trajectory-kills", "trajectory-kills", {
    "design": "design", "kills": "kills", "committed": "committed", "lost": "lost",
    "unreadable files": "unreadable files", "trajectories/s": "trajectories/s"})


tables("step-limits", "time-steps", title="Limits")


@block("step-laws", "time-steps")
def step_laws(result: dict) -> str:
    return selected(result, title="Laws")


@block("step-errors", "time-steps")
def step_errors(result: dict) -> str:
    return f"{selected(result, title='Errors')}\n\n{texts_of(result)[-1]}"


tables("windows", "windows", {
    "law": "law", "window s": "window, s", "b0": "b0", "√Y: slope": "√Y: slope",
    "intercept": "intercept", "adj. R²": "adj. R²", "β: slope": "β: slope",
    "intercept (7)": "intercept", "adj. R² (8)": "adj. R²"})
