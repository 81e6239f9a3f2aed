# SPDX-License-Identifier: BSD-3-Clause
"""The contents of a folder: studies, recordings, fits, calibrations, comparisons, diagnoses,
laboratories."""
from __future__ import annotations

from pathlib import Path

from command_results import (CalibrationError, CalibrationResults, Comparison, ComparisonError,
                             Diagnosis, DiagnosisError, FitError, FitResults, Laboratory,
                             LaboratoryError, TrackError, TrackResults)
from culm.archive import Study, StudyError
from report_page.calibration import calibration_section
from report_page.comparison import comparison_section
from report_page.diagnosis import diagnosis_section
from report_page.laboratory import laboratory_section
from report_page.markup import Section
from report_page.measurements import fit_section, recording_section
from report_page.study import study_section

class UnexpectedContent(Exception):
    """The content of a file does not follow its schema; one sentence."""


REFUSALS = (StudyError, CalibrationError, ComparisonError, DiagnosisError, FitError,
            LaboratoryError, TrackError, UnexpectedContent)


class NothingToReport(Exception):
    """The folder contains no results; one sentence."""


def _study(folder: Path, _: Path, key: str, place: str) -> Section:
    with Study(folder) as study:
        return study_section(study, key, place)


def _laboratory(folder: Path, page_folder: Path, key: str, place: str) -> Section:
    return laboratory_section(Laboratory(folder), page_folder, key, place)


# For each kind of result its file, its name and the function that makes its section from the
# result's folder and that of the page, in page order.
KINDS = (
    ("study.h5", "study", _study),
    ("track.json", "recording",
     lambda folder, _, *names: recording_section(TrackResults(folder), *names)),
    ("fit.json", "fit", lambda folder, _, *names: fit_section(FitResults(folder), *names)),
    ("calibration.json", "calibration",
     lambda folder, _, *names: calibration_section(CalibrationResults(folder), *names)),
    ("comparison.json", "comparison",
     lambda folder, _, *names: comparison_section(Comparison(folder), *names)),
    ("diagnosis.json", "diagnosis",
     lambda folder, _, *names: diagnosis_section(Diagnosis(folder), *names)),
    ("laboratory.json", "laboratory", _laboratory),
)


def folders_of(directory: Path) -> list[Path]:
    """The folder itself and those in it."""
    return [directory, *sorted(path for path in directory.iterdir() if path.is_dir())]


def _section(make, file: Path, page_folder: Path, key: str, place: str) -> Section:
    """Makes the section; raises UnexpectedContent if the document does not follow its schema."""
    try:
        return make(file.parent, page_folder, key, place)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise UnexpectedContent(f"{file}: not as this version of culm writes it: "
                                f"{type(error).__name__}, {error}.") from error


def sections_of(directory: Path, page_folder: Path) -> list[Section]:
    """A section for every result in the folder and in its direct subfolders, for a page in
    `page_folder`; the section of an unreadable result states why. Raises NothingToReport, or the
    reader's error if all fail."""
    if not directory.is_dir():
        raise NothingToReport(f"{directory} is not a folder.")
    sections, refusals, counts = [], [], {}
    folders = folders_of(directory)
    for file, kind, make in KINDS:
        for folder in folders:
            if not (folder / file).is_file():
                continue
            counts[kind] = counts.get(kind, 0) + 1
            key = kind if counts[kind] == 1 else f"{kind}-{counts[kind]}"
            place = folder.resolve().name
            try:
                sections.append(_section(make, folder / file, page_folder, key, place))
            except REFUSALS as error:
                refusals.append(error)
                sections.append(Section(key, f"{kind.capitalize()} ({place})", "doubt",
                                        [f"Not on this page: {error}"]))
    if not sections:
        known = ", ".join(file for file, _, _ in KINDS)
        raise NothingToReport(f"{directory} holds no results: neither in it nor in a folder of it is "
                              f"any of {known} (culm run|track|fit|calibrate|compare|diagnose -o).")
    if len(refusals) == len(sections):
        raise refusals[0]
    return sections
