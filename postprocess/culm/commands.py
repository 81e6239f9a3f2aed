# SPDX-License-Identifier: BSD-3-Clause
"""The commands of culm as functions."""
from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from culm.archive import Study
from culm.program import InputError, execute
from culm.results import Calibration, Comparison, Diagnosis, Simulation
from culm.study_text import study_text

Folders = str | os.PathLike | Iterable[str | os.PathLike]


def run(study: Mapping | str | os.PathLike, output: str | os.PathLike | None = None, *,
        ranks: int = 2, resume: bool = False, retry_failed: bool = False,
        walltime: str | None = None, progress: bool = True) -> Study:
    """Runs a study, a dict or a file, and returns its archive.

    `output` is the folder; without it, results/<study.name>, or results/<name of the file>. With
    `resume` a study that is there is completed or extended; otherwise it is refused. A dict is
    written to <output>.toml, so that the study can be run again without Python.
    Raises InputError, StoppedEarly (go on with resume=True), StudyError; warns with FailedPoints.
    """
    file = study
    if isinstance(study, Mapping):
        name = study.get("study", {}).get("name")
        if output is None and name is None:
            raise InputError("a study without output needs a name: {\"study\": {\"name\": …}}")
        output = Path("results") / name if output is None else Path(output)
        file = output.with_name(output.name + ".toml")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(study_text(study), encoding="utf-8")
    options = _option("-o", output) + ["--resume"] * resume + ["--retry-failed"] * retry_failed + _option(
        "--walltime", walltime)
    printed = execute(["run", file, *options], ranks, progress)
    return Study(re.search(r"^archive (.+)$", printed, re.MULTILINE)[1])


def calibrate(folders: Folders, effects: Iterable[str] = (), *, ranks: int = 1,
              output: str | os.PathLike | None = None, law: str | None = None,
              spheres: int | None = None, window: float | None = None,
              progress: bool = True) -> Calibration:
    """Fits the chain to measured stems: Y and β with their uncertainty (docs/calibration.md).

    `folders`: a measurement folder, or several. `effects`: as in `--with`, for example
    ["still_air", "quadratic_drag(drag_coefficient=1.2)"]. `window` in s.
    """
    document, text = _document("calibrate", _paths(folders), ranks, progress,
                               _option("--with", ",".join(effects)), _option("-o", output),
                               _model_options(law, spheres, window))
    return Calibration.of(document, text)


def compare(folder: str | os.PathLike, effects: Iterable[str] = (), *, one_by_one: bool = False,
            output: str | os.PathLike | None = None, law: str | None = None,
            spheres: int | None = None, window: float | None = None,
            progress: bool = True) -> Comparison:
    """Compares the chain, and the chain with effects, with a measurement (docs/compare.md).

    The effects are added together, or `one_by_one` (`--ladder`).
    """
    document, text = _document("compare", [folder], 1, progress,
                               _option("--ladder" if one_by_one else "--with", ",".join(effects)),
                               _option("-o", output), _model_options(law, spheres, window))
    return Comparison.of(document, text)


def diagnose(folders: Folders, *, candidates: Iterable[str] = (), known: Iterable[str] = (),
             ranks: int = 1, output: str | os.PathLike | None = None, resume: bool = False,
             law: str | None = None, spheres: int | None = None, window: float | None = None,
             progress: bool = True) -> Diagnosis:
    """Finds which effect is missing (docs/diagnosis.md).

    Recordings of one specimen are explained together, several specimens are a laboratory. Without
    `candidates` all effects that apply are tried. `resume` needs `output`.
    """
    document, text = _document("diagnose", _paths(folders), ranks, progress,
                               _option("--candidates", ",".join(candidates)),
                               _option("--known", ",".join(known)), _option("-o", output),
                               ["--resume"] * resume, _model_options(law, spheres, window))
    return Diagnosis.of(document, text)


def simulate(study: Mapping | str | os.PathLike, bond_youngs_modulus_gpa: float,
             bond_damping: float) -> Simulation:
    """Simulates one stem of a study, a dict or a file, with these parameters."""
    with tempfile.TemporaryDirectory(prefix="culm-") as place:
        if isinstance(study, Mapping):
            file = Path(place) / "study.toml"
            file.write_text(study_text(study), encoding="utf-8")
        else:
            file = Path(study)
        answer = Path(place) / "answer.json"
        execute(["simulate", file, "--bond-youngs-modulus-gpa", repr(float(bond_youngs_modulus_gpa)),
                 "--bond-damping", repr(float(bond_damping)), "--json", answer], progress=False)
        found = json.loads(answer.read_text(encoding="utf-8"))[0]
    return Simulation(found["bond_youngs_modulus_pa"], found["bond_damping"],
                      found["decay_per_cycle"], found["frequency_hz"], found)


def _document(command: str, folders: list, ranks: int, progress: bool, *options) -> tuple[dict, str]:
    """The JSON document and the text of a command about measurements."""
    if not folders:
        raise InputError("no measurement folder was given")
    with tempfile.TemporaryDirectory(prefix="culm-") as place:
        answer = Path(place) / "answer.json"
        words = [word for option in options for word in option]
        text = execute([command, *folders, *words, "--json", answer], ranks, progress)
        return json.loads(answer.read_text(encoding="utf-8")), text


def _option(name: str, value) -> list:
    return [] if value is None or value == "" else [name, value]


def _model_options(law: str | None, spheres: int | None, window: float | None) -> list:
    return [*_option("--law", law), *_option("--spheres", spheres), *_option("--window", window)]


def _paths(folders: Folders) -> list:
    return [folders] if isinstance(folders, (str, os.PathLike)) else list(folders)
