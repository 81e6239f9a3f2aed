#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""All answers of one build of culm in one file, to compare builds with each other.

    bench/answers.py collect --build BUILD --data DATA -o ANSWERS.json [--ranks N] [--work FOLDER] [--part PART]...
    bench/answers.py compare OLD.json NEW.json

`collect` runs `culm diagnose` and `culm compare` on the labelled recordings of DATA/hidden-effect,
`culm calibrate` on the stems of DATA/lab-population, and `bench_diagnosis` on fixed seeds; it keeps
what each command wrote in FOLDER and goes on from there if it is started again. BUILD is a build
folder with benchmarks (-DCULM_BUILD_BENCHMARKS=ON).

`compare` lists every verdict and every set of named effects that differ, and every number that
differs by more than a tenth of its standard error. Exit code: 0 none differs, 1 some do.
"""
import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys
import time

LABELLED = ["T1-null", "T2-quadratic_drag", "T3-clamp_compliance", "T4-bending_nonlinearity", "T5-relaxation",
            "T6-clamp_friction", "T7-quadratic_drag+clamp_compliance"]
# kind, seed, cases: all of them were opened before, so that they measure change and not skill.
DRAWN = [("null", 6, 20), ("single", 9, 30), ("pair", 10, 10), ("unknown", 4, 6)]
PARTS = ["diagnose", "compare", "calibrate", "drawn"]
LARGEST_SHIFT = 0.1  # of a standard error


def command(program: list[str], ranks: int) -> list[str]:
    return (["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []) + program


def run_once(out: pathlib.Path, program: list[str], ranks: int) -> dict:
    """What the program wrote into `out`, with the seconds that it took; of an earlier run if there was one."""
    times = out.with_suffix(".seconds")
    if not times.exists():
        out.parent.mkdir(parents=True, exist_ok=True)
        environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        start = time.monotonic()
        done = subprocess.run(command(program, ranks), env=environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode not in (0, 3):
            raise SystemExit(f"{' '.join(program)}: exit code {done.returncode}\n{done.stderr}")
        times.write_text(f"{time.monotonic() - start:.1f}\n")
    return json.loads(out.read_text()) | {"wall_s": float(times.read_text())}


def numbers(parameters: dict) -> dict:
    """Of a JSON table of parameters: {name: [value, standard error]}."""
    return {name: [each["value"], each.get("stderr")] for name, each in parameters.items()
            if isinstance(each, dict) and "value" in each}


def diagnosis(document: dict) -> dict:
    return {"verdict": document["verdict"], "effects": sorted(document["effects"]),
            "alternatives": document["alternatives"],
            "parameters": numbers(document["parameters"]),
            "baseline": numbers(document["baseline"]["parameters"]),
            "ladder": [{"model": rung["model"], "finding": rung["finding"], "rmse_mm": rung["rmse_mm"], "reduced_chi2": rung["reduced_chi2"]}
                       for rung in document["ladder"]],
            "wall_s": document["wall_s"]}


def collect(options: argparse.Namespace) -> int:
    work = options.work or options.output.with_suffix(".work")
    culm = str(options.build / "src/cli/culm")
    hidden = options.data / "hidden-effect"
    cases: dict[str, dict] = {}
    parts = options.part or PARTS
    if "diagnose" in parts:
        for name in LABELLED:
            out = work / "diagnose" / f"{name}.json"
            cases[f"diagnose {name}"] = diagnosis(run_once(out, [culm, "diagnose", str(hidden / name), "--json", str(out)],
                                                           options.ranks))
    if "compare" in parts:
        for name in LABELLED:
            out = work / "compare" / f"{name}.json"
            effects = [] if name == "T1-null" else ["--with", name.split("-", 1)[1].replace("+", ",")]
            document = run_once(out, [culm, "compare", str(hidden / name), *effects, "--json", str(out)], options.ranks)
            for model in document["ladder"]:
                cases[f"compare {name}: {' + '.join(model['model'])}"] = {
                    "finding": model["verdict"]["finding"], "parameters": numbers(model["parameters"]),
                    "rmse_mm": model["rmse_mm"], "reduced_chi2": model["reduced_chi2"], "wall_s": document["wall_s"]}
    if "calibrate" in parts:
        out = work / "calibrate" / "lab-population.json"
        document = run_once(out, [culm, "calibrate", str(options.data / "lab-population"), "--json", str(out)], options.ranks)
        for stem in document["stems"]:
            cases[f"calibrate {stem['measurement']}"] = {"parameters": numbers(stem["parameters"]), "rmse_mm": stem["fit"]["rmse_mm"],
                                                "adequate": stem["fit"]["adequate"], "wall_s": document["wall_s"]}
    if "drawn" in parts:
        for kind, seed, count in DRAWN:
            folder = work / "drawn" / kind
            program = [str(options.build / "bench/bench_diagnosis"), "--kind", kind, "--seed", str(seed), "--cases", str(count),
                       "--results", str(folder), "--limit", "900"]
            environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
            if len(list(folder.glob("*.json"))) < count:
                subprocess.run(command(program, options.ranks), env=environment, stdin=subprocess.DEVNULL, check=True)
            for path in sorted(folder.glob("*.json")):
                case = json.loads(path.read_text())
                cases[f"drawn seed {seed} {kind} {case['number']:03d}"] = case
    version = subprocess.run([culm, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    answers = {"version": version, "date": time.strftime("%Y-%m-%d", time.gmtime()), "processor": platform.processor() or platform.machine(),
               "ranks": options.ranks, "cases": cases}
    options.output.write_text(json.dumps(answers, indent=1, sort_keys=True) + "\n")
    print(f"{len(cases)} answers of {version} in {options.output}")
    return 0


def flat(value, path: str = "") -> dict:
    """Every leaf of a JSON value by its path; a pair [value, standard error] is a leaf."""
    if isinstance(value, dict):
        return {key: leaf for name, each in value.items() for key, leaf in flat(each, f"{path}.{name}" if path else name).items()}
    if isinstance(value, list) and not (len(value) == 2 and all(isinstance(each, (int, float, type(None))) for each in value)):
        return {key: leaf for k, each in enumerate(value) for key, leaf in flat(each, f"{path}[{k}]").items()}
    return {path: value}


TIMING = ("wall_s", "seconds", "cpu_s", "runs")


def differences(old: dict, new: dict):
    old_leaves, new_leaves = flat(old), flat(new)
    for path in sorted(old_leaves.keys() | new_leaves.keys()):
        if path.rsplit(".", 1)[-1] in TIMING:
            continue
        a, b = old_leaves.get(path), new_leaves.get(path)
        if a == b:
            continue
        if isinstance(a, list) and isinstance(b, list) and None not in (a[0], b[0]):
            if a[1] and abs(a[0] - b[0]) <= LARGEST_SHIFT * a[1]:
                continue
        elif isinstance(a, (int, float)) and isinstance(b, (int, float)) and not isinstance(a, bool):
            if abs(a - b) <= 2e-3 * max(abs(a), abs(b)):  # what has no standard error: residuals, scores
                continue
        yield path, a, b


def compare(options: argparse.Namespace) -> int:
    old, new = (json.loads(path.read_text()) for path in (options.old, options.new))
    print(f"{old['version']} ({old['date']}) against {new['version']} ({new['date']})")
    changed = 0
    for name in sorted(old["cases"].keys() | new["cases"].keys()):
        if name not in old["cases"] or name not in new["cases"]:
            print(f"{name}: only in the {'new' if name in new['cases'] else 'old'} file")
            changed += 1
            continue
        found = list(differences(old["cases"][name], new["cases"][name]))
        changed += bool(found)
        for path, a, b in found:
            print(f"{name}: {path}: {a} -> {b}")
    print(f"{changed} of {len(old['cases'])} answers differ")
    return 1 if changed else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    collecting = commands.add_parser("collect", help="run everything and keep the answers")
    collecting.add_argument("--build", type=pathlib.Path, required=True, help="build folder with benchmarks")
    collecting.add_argument("--data", type=pathlib.Path, required=True, help="folder of hidden-effect and lab-population")
    collecting.add_argument("-o", "--output", type=pathlib.Path, required=True)
    collecting.add_argument("--work", type=pathlib.Path, help="where the commands write; default: beside the output")
    collecting.add_argument("--ranks", type=int, default=2)
    collecting.add_argument("--part", action="append", choices=PARTS, help="only this part; may be repeated")
    collecting.set_defaults(action=collect)
    comparing = commands.add_parser("compare", help="what differs between two files")
    comparing.add_argument("old", type=pathlib.Path)
    comparing.add_argument("new", type=pathlib.Path)
    comparing.set_defaults(action=compare)
    options = parser.parse_args()
    return options.action(options)


if __name__ == "__main__":
    sys.exit(main())
