# SPDX-License-Identifier: BSD-3-Clause
"""What bench/publish.sh measures: a file of bench/results for each, the command, and the folders
whose changes make the file stale."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

CHAIN = ("src/core", "src/physics", "src/integrate", "src/run")
STUDY = (*CHAIN, "src/reduce", "src/farm", "src/archive", "src/study", "config/schramm2019.toml",
         "config/schramm2019-sundials.toml")
FIT = (*CHAIN, "src/reduce", "src/measure/folder", "src/fit", "src/residuals", "src/calibrate")
DIAGNOSIS = (*FIT, "src/diagnose", "tests/beam_generator", "bench/misstated_inputs.hpp",
             "bench/reading_noise.hpp")


def whole(case: dict) -> dict:
    return case


@dataclass(frozen=True)
class Measurement:
    """One file of bench/results.

    `command` may contain {build}, {bench} (its folder of programs), {launch} (mpirun with two
    ranks), {scratch} (an empty folder), {root} and {file}. A command with {file} adds cases to that
    file until it holds all; another prints Markdown tables, whose rows are the cases. A measurement
    whose variable `needs` is not set is left out; its file then stays as it is.
    """

    name: str
    question: str
    command: str
    sources: tuple[str, ...]
    minutes: float  # on two cores of a Xeon at 2.8 GHz, for the plan
    keep: Callable[[dict], dict] = whole  # what of a case is stored
    summary: str = ""  # beginning of the first line of the summary that follows the cases
    needs: str = ""  # variable of the environment that names a program or data: $NAME in the command


def rounded(value, digits: int = 6):
    """Numbers with `digits` significant digits, in lists and objects too."""
    if isinstance(value, dict):
        return {key: rounded(each, digits) for key, each in value.items()}
    if isinstance(value, list):
        return [rounded(each, digits) for each in value]
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def of_decision(case: dict) -> dict:
    kept = {key: case[key] for key in ("kind", "number", "grade", "verdict", "hidden", "seconds")}
    kept["candidates"] = [" + ".join("/".join(each["members"]) for each in answer)
                          for answer in case["candidates"]]
    kept["explanations"] = [[each["probability"], each["is_truth"]]
                            for each in case.get("explanations", [])]
    kept["sizes"] = case.get("sizes", [])
    if case["grade"] == "failed":
        kept["reason"] = case["reason"]
    return rounded(kept, 4)


def of_laboratory(case: dict) -> dict:
    kept = {key: case.get(key, []) for key in ("number", "kind", "conclusion", "hidden_in_rig",
                                               "rig_answers", "own_answers", "named", "seconds")}
    kept["stems"] = [{key: stem[key] for key in ("name", "named", "own")}
                     for stem in case["stems"] if stem["named"] or stem["own"]]
    return rounded(kept | {"stem_count": len(case["stems"])}, 4)


def of_coverage(case: dict) -> dict:
    return rounded({"number": case["number"], "parameters": case["parameters"]}, 5)


def of_moving(case: dict) -> dict:
    return rounded({key: case[key] for key in ("number", "hidden", "same_answer", "same_model",
                                               "complete", "cut")}, 4)


def of_video(case: dict) -> dict:
    return rounded({key: case[key] for key in ("number", "answer", "damping", "youngs_modulus",
                                               "reading_error_px", "stated_uncertainty_px")}, 4)


MEASUREMENTS = (
    Measurement("diagnosis", "How often does a diagnosis of one stem name the right effect?",
                "{bench}/bench_decision judging {file}",
                (*DIAGNOSIS, "bench/decision.cpp", "bench/decision_cases.cpp",
                 "bench/decision_grade.cpp"), 45, of_decision),
    Measurement("rig-effects", "How often is an effect of a rig found?",
                "{launch} {bench}/bench_laboratories 0 20 {file}",
                (*DIAGNOSIS, "src/farm", "bench/laboratories.cpp", "bench/laboratory_cases.hpp"),
                9, of_laboratory, "effects of rigs:"),
    Measurement("intervals", "Do 95 % intervals contain the truth?",
                "{bench}/bench_uncertainty_coverage 2001 100 {file}",
                (*DIAGNOSIS, "bench/uncertainty_coverage.cpp"), 5, of_coverage),
    Measurement("flawed-noise", "Does flawed noise lead to a wrong verdict?",
                "{bench}/bench_noise_rules {file}", (*DIAGNOSIS, "bench/noise_rules.cpp"), 2,
                rounded, "adequate:"),
    Measurement("late-starts", "Does a recording that begins late have the same answer?",
                "{bench}/bench_moving_recordings 301 6 {file}",
                (*DIAGNOSIS, "bench/moving_recordings.cpp"), 4, of_moving, "The same answer:"),
    Measurement("videos", "Are deflections from video accurate?",
                "{bench}/bench_tracked_videos 201 6 {file}",
                (*DIAGNOSIS, "src/measure", "bench/tracked_videos.cpp"), 4, of_video),
    Measurement("explicit-step", "How long does an explicit step take?",
                "{bench}/bench_explicit_step", (*CHAIN, "bench/explicit_step.cpp"), 1),
    Measurement("peer-step", "How much faster is it than the authors' code?",
                "{root}/bench/peer_step.sh $LIGGGHTS {build}",
                (*CHAIN, "bench/explicit_step.cpp", "bench/peer_step.sh"), 1, needs="LIGGGHTS"),
    Measurement("stems", "How long does a stem take?", "{bench}/bench_implicit_batches",
                (*CHAIN, "bench/implicit_batches.cpp"), 2),
    Measurement("tolerance", "How accurate is a run?", "{bench}/bench_implicit_tolerance",
                (*CHAIN, "src/reduce", "bench/implicit_tolerance.cpp"), 2),
    Measurement("methods", "Which implicit method is the cheapest?",
                "{bench}/bench_implicit_methods",
                (*CHAIN, "src/reduce", "bench/implicit_methods.cpp"), 2),
    Measurement("study-methods", "How long does a study take by each method?",
                "{root}/bench/study_methods.sh {build}", (*STUDY, "bench/study_methods.sh"), 0.2),
    Measurement("study-overhead", "What does a study cost beyond its runs?",
                "{root}/bench/study_overhead.sh {build}", (*STUDY, "bench/study_overhead.sh"), 0.4),
    Measurement("farm", "Which share of the time do farm and archive take?",
                "{root}/bench/farm.sh {build} {scratch}",
                (*STUDY, "bench/farm.sh", "bench/farm.cpp", "bench/farm_synthetic.cpp"), 6),
    Measurement("large-study", "What does a million points cost?",
                "{bench}/bench_large_study 1000000 {scratch}", (*STUDY, "bench/large_study.cpp"), 0.5),
    Measurement("many-ranks", "How efficient are many ranks?",
                "{bench}/bench_farm_prediction {root}/config/schramm2019.toml",
                ("src/farm", "src/study/execute", "bench/farm_prediction.cpp",
                 "bench/simulated_farm.cpp"), 1),
    Measurement("fits", "How long do a calibration and a diagnosis take?",
                "{root}/bench/recording_times.sh {build}",
                (*FIT, "src/diagnose", "bench/recording_times.sh"), 2),
    Measurement("spheres", "What does the number of spheres change?",
                "/usr/bin/python3 {root}/bench/sphere_counts.py {build}",
                (*FIT, "bench/sphere_counts.py"), 0.2),
    Measurement("effect-matrix", "Which effects can explain which recordings?",
                "/usr/bin/python3 {root}/bench/effect_matrix.py {build}",
                (*FIT, "src/diagnose", "bench/effect_matrix.py"), 3),
    Measurement("population", "How accurate are fits of 29 stems whose clamps yield?",
                "/usr/bin/python3 {root}/bench/population.py {build} $CULM_OPTIONAL_DATA",
                (*FIT, "bench/population.py"), 0.4, needs="CULM_OPTIONAL_DATA"),
    Measurement("real-recordings", "What does culm answer to real recordings?",
                "/usr/bin/python3 {root}/bench/real_recordings.py {build} $CULM_OPTIONAL_DATA",
                (*DIAGNOSIS, "src/measure", "bench/real_recordings.py"), 5,
                needs="CULM_OPTIONAL_DATA"),
    Measurement("time-steps", "How large may an explicit step be, and what does it change?",
                "/usr/bin/python3 {root}/bench/time_steps.py {build} {scratch}",
                (*STUDY, "config/timestep.toml", "config/timestep-consistent.toml",
                 "bench/time_steps.py"), 2),
    Measurement("spreads", "How much of the measured spread do geometry, modulus and damping explain?",
                "/usr/bin/python3 {root}/bench/population_spreads.py {build} {scratch}",
                (*STUDY, "config/replicates.toml", "bench/population_spreads.py",
                 "bench/time_steps.py"), 0.4),
    Measurement("closing-tests", "How far are simulated stems from the readings they were made for?",
                "/usr/bin/python3 {root}/bench/closing_tests.py {build} {scratch}",
                (*STUDY, "bench/closing_tests.py", "bench/time_steps.py"), 0.1),
    Measurement("windows", "What do window, law and b0 change in the regressions?",
                "{root}/jobs/reproduction.sh {build}/src/cli/culm {scratch}",
                (*STUDY, "config/reproduction-schramm2019.toml",
                 "config/reproduction-consistent.toml", "jobs/reproduction.sh",
                 "postprocess/reproduction_table.py"), 0.1),
    Measurement("kills", "What is lost when processes are killed?",
                "{root}/bench/kill_counts.sh {build}",
                ("src/core", "src/farm", "src/archive", "src/study", "tests/faults",
                 "bench/kill_counts.sh"), 3),
    Measurement("trajectory-kills", "Which design of trajectory files survives a kill?",
                "{bench}/bench_trajectory_designs {scratch} 60",
                ("src/core", "src/archive", "bench/trajectory_designs.cpp"), 1),
)
