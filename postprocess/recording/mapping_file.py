# SPDX-License-Identifier: BSD-3-Clause
"""Reads the tables of a mapping of `culm import` that describe the recording (docs/measurements.md).

Those that describe the stem are read by the program that reads stem.toml; they are copied."""
from __future__ import annotations

import difflib
import json
import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from recording.invalid_readings import InvalidOptions
from recording.refusal import Refusal
from recording.text_form import DELIMITERS
from recording.text_table import TextOptions
from recording.time_stamps import UNITS as TIME_UNITS

KEYS = {
    "source": ["file", "delimiter", "decimal", "skip_lines", "encoding", "missing_values",
               "invalid_if", "stuck_values", "factors"],
    "time": ["column", "rate_hz", "unit", "repeated_times", "release_s", "before_s", "after_s",
             "readings_per_mean"],
    "motion": ["unit", "mm_per_px", "axis", "sign", "zero"],
    "clamp": ["markers", "columns"],
    "height": ["height_mm", "height_m", "markers", "columns"]}
MOTION_UNITS = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "px": 1.0}  # in mm
ZEROS = ("before_release", "at_rest", "as_given")
MOST_HEIGHTS, MOST_NAMES, MOST_FAULTS = 10_000, 1000, 12
ANY_TIME = 1e12


class WrittenNumber(float):
    """A number with the text by which the file gives it, so that a copy has the same digits."""

    def __new__(cls, text: str):
        number = super().__new__(cls, text)
        number.text = text
        return number


@dataclass
class MappedHeight:
    millimetres: float
    names: list[str]


@dataclass
class Mapping:
    document: dict
    source: Path
    text: TextOptions
    invalid: InvalidOptions
    factors: dict[str, float] = field(default_factory=dict)  # by column
    has_markers: bool = False
    time_column: str | None = None
    rate_hz: float | None = None
    time_unit: str = "s"
    repeated_times: str | None = None
    readings_per_mean: int | None = None
    release: float | str | None = None  # s on the recording's clock, "detect", None: moving
    before: float | None = None
    after: float | None = None
    unit: str = "mm"
    mm_per_px: float = 1.0
    axis: list[float] = field(default_factory=list)
    sign: float = 1.0
    zero: str = "as_given"
    clamp: list[str] = field(default_factory=list)
    heights: list[MappedHeight] = field(default_factory=list)

    @property
    def sensors(self) -> list[dict]:
        return self.document.get("sensor", [])

    @property
    def stem(self) -> dict:
        return self.document.get("stem", {})

    @property
    def length_mm(self) -> float | None:
        """Of the stem; None if it is not stated. Its sign and size are checked with stem.toml's."""
        if "length_mm" in self.stem:
            return self.stem["length_mm"]
        return 1e3 * self.stem["length_m"] if "length_m" in self.stem else None

    @property
    def fps(self) -> float | None:
        return self.document.get("camera", {}).get("fps")

    def names_used(self) -> list[str]:
        names = self.clamp + [name for height in self.heights for name in height.names]
        return list(dict.fromkeys(names + [sensor["column"] for sensor in self.sensors]))


class Faults:
    """Every mistake of the file, with its line."""

    def __init__(self, file: Path, text: str):
        self.file, self.lines, self.found = file, text.splitlines(), []

    def line_of(self, table: str, index: int, key: str) -> int:
        """The line of a key, else of its table's header; 0 if there is neither."""
        at, here, count = 0, "", -1
        for number, line in enumerate(self.lines, 1):
            header = re.match(r"\s*\[\[?\s*([\w.\"]+)\s*\]\]?", line)
            if header:
                here = header[1]
                count += here == table
                at = number if here == table and count == index else at
            elif here == table and count == index and re.match(rf"\s*\"?{key}\"?\s*=", line):
                return number
        return at

    def add(self, text: str, table: str, key: str = "", index: int = 0):
        line = self.line_of(table, index, key)
        self.found.append((line, f"{self.file}{f':{line}' if line else ''}: {text}"))

    def raise_if_any(self, others: str):
        texts = [text for _, text in sorted(self.found, key=lambda found: found[0])]
        if len(texts) > MOST_FAULTS:
            texts[MOST_FAULTS:] = [f"{self.file}: and {len(texts) - MOST_FAULTS} more mistakes"]
        texts += [others] if others else []
        if texts:
            raise Refusal("\n".join(texts), is_complete=True)


class Section:
    """One table of the mapping. A getter returns None for a key that is absent or wrong."""

    def __init__(self, faults: Faults, name: str, content, index: int = 0):
        self.faults, self.name, self.index = faults, name, index
        self.content = content if isinstance(content, dict) else {}
        if not isinstance(content, dict):
            self.fault("", f"must be a table [{name}]")
        for key in self.content:
            if key not in KEYS[name]:
                self.fault(key, f"unknown key{self.hint(key)}")

    def hint(self, key: str) -> str:
        places = [table for table, keys in KEYS.items() if key in keys]
        near = difflib.get_close_matches(key, KEYS[self.name], 1, 0.6)
        if places:
            return f"; it belongs into [{places[0]}]"
        return f" (did you mean {near[0]}?)" if near else f"; known are {', '.join(KEYS[self.name])}"

    def fault(self, key: str, text: str):
        value = f" = {toml_value(self.content[key])}" if key in self.content else ""
        self.faults.add(f"{self.name}{'.' if key else ''}{key}{value}: {text}", self.name, key,
                        self.index)

    def missing(self, key: str, text: str):
        if key not in self.content:
            self.fault(key, f"is missing: {text}")

    def typed(self, key: str, kinds, allowed: str):
        value = self.content.get(key)
        if value is None or (isinstance(value, kinds) and not isinstance(value, bool)):
            return value
        self.fault(key, f"must be {allowed}")
        return None

    def text(self, key: str) -> str | None:
        return self.typed(key, str, "a text in quotes")

    def word(self, key: str, words) -> str | None:
        value = self.text(key)
        if value is None or value in words:
            return value
        listed = ", ".join(f'"{word}"' for word in words)
        near = difflib.get_close_matches(value, list(words), 1, 0.5)
        self.fault(key, f"must be one of {listed}" + (f' (did you mean "{near[0]}"?)' if near else ""))
        return None

    def number(self, key: str, low: float, high: float) -> float | None:
        value = self.typed(key, (int, float), f"a number from {low:g} to {high:g}")
        if value is not None and not low <= value <= high:
            self.fault(key, f"must be a number from {low:g} to {high:g}")
            return None
        return value

    def texts(self, key: str) -> list[str] | None:
        value = self.typed(key, (str, list), "a text or a list of texts")
        value = [value] if isinstance(value, str) else value
        if value is not None and not all(isinstance(text, str) for text in value):
            self.fault(key, "must be a text or a list of texts")
            return None
        return value

    def numbers(self, key: str) -> list[float] | None:
        value = self.typed(key, list, "a list of numbers")
        if value is not None and not all(isinstance(x, (int, float)) and math.isfinite(x)
                                         for x in value):
            self.fault(key, "must be a list of numbers")
            return None
        return value


def toml_value(value) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(entry) for entry in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml_value(v)}" for k, v in value.items()) + " }"
    return getattr(value, "text", None) or repr(value)


def read_source(section: Section, mapping: Mapping, folder: Path, named: Path | None):
    file = section.text("file")
    if named is None:
        section.missing("file", "the recording, relative to this file")
        if file is not None and (Path(file).is_absolute() or ".." in Path(file).parts):
            section.fault("file", "must lie in the folder of the file that names it, or below; "
                                  "`culm import --recording` takes any file")
        mapping.source = folder / (file or "")
    word = section.word("delimiter", DELIMITERS)
    mapping.text = TextOptions(DELIMITERS.get(word), section.word("decimal", (".", ",")),
                               section.number("skip_lines", 0, 100_000), section.text("encoding"))
    factors = section.typed("factors", dict, "a table of columns and numbers")
    for column, factor in (factors or {}).items():
        if isinstance(factor, bool) or not isinstance(factor, (int, float)) or factor == 0:
            section.fault("factors", f'the factor of "{column}" must be a number that is not 0')
        else:
            mapping.factors[column] = float(factor)
    stuck = section.word("stuck_values", ("gap", "keep"))
    mapping.invalid = InvalidOptions(section.numbers("missing_values"), section.texts("invalid_if"),
                                     stuck == "keep")


def read_time(section: Section, mapping: Mapping):
    mapping.time_column = section.text("column")
    mapping.rate_hz = section.number("rate_hz", 1e-3, 1e9)
    if mapping.has_markers:
        mapping.time_column = "t"
        for key in ("column", "rate_hz"):
            if key in section.content:
                section.fault(key, "a file with markers has its own times")
    elif "rate_hz" in section.content and "column" in section.content:
        section.fault("rate_hz", "is given in addition to column: one of them is enough")
    elif "rate_hz" not in section.content:
        section.missing("column", "the name or the number of the time column, in quotes (or "
                                  "rate_hz, the samples per second of a recording without times)")
    mapping.time_unit = section.word("unit", (*TIME_UNITS, "frame")) or "s"
    if mapping.time_unit == "frame" and not mapping.fps:
        section.fault("unit", "frame numbers need [camera] fps")
    mapping.repeated_times = section.word("repeated_times", ("spread", "drop"))
    is_moving = mapping.document.get("release", {}).get("kind") == "moving"
    release = section.content.get("release_s")
    if isinstance(release, str) and release != "detect":
        section.fault("release_s", 'must be a number or "detect"')
    elif release != "detect":
        release = section.number("release_s", -ANY_TIME, ANY_TIME)
    if not is_moving:
        section.missing("release_s", 'time of the release in the recording, or "detect"')
    elif "release_s" in section.content:
        section.fault("release_s", 'the release was not recorded ([release] kind = "moving")')
    mapping.release = None if is_moving else release
    mapping.before = section.number("before_s", 0.0, 1e6)
    mapping.after = section.number("after_s", 1e-9, 1e6)
    if (size := section.number("readings_per_mean", 1, 1e6)) is not None:
        mapping.readings_per_mean = round(size)


def read_motion(section: Section, mapping: Mapping):
    unit = section.word("unit", MOTION_UNITS)
    mapping.unit = unit or "mm"
    if unit == "px":
        section.missing("mm_per_px", "the scale of the picture")
        mapping.mm_per_px = section.number("mm_per_px", 1e-9, 1e3) or 1.0
    axis = section.numbers("axis")
    sign = section.number("sign", -1, 1)
    if sign is not None and sign not in (-1, 1):
        section.fault("sign", "must be 1 or -1")
    mapping.sign = sign or 1.0
    if mapping.has_markers:
        section.missing("axis", "direction of positive deflection, [x, y, z]")
        length = math.hypot(*axis) if axis and len(axis) == 3 else 0.0
        if "axis" in section.content and length == 0.0:
            section.fault("axis", "must be three numbers, not all 0")
        mapping.axis = [x / length for x in axis] if length else [0.0, 0.0, 0.0]
        for key, text in (("unit", "a file with markers says its own"),
                          ("sign", "belongs to tables; turn the axis round instead")):
            if key in section.content:
                section.fault(key, text)
    else:
        section.missing("unit", 'of the deflections: "mm", "cm", "m", "um" or "px"')
    section.missing("zero", '"before_release" (held straight), "at_rest" or "as_given"')
    mapping.zero = section.word("zero", ZEROS) or "as_given"


def named_series(section: Section, has_markers: bool) -> list[str]:
    key, other = ("markers", "columns") if has_markers else ("columns", "markers")
    if other in section.content:
        section.fault(other, f"belongs to {'tables' if has_markers else 'files with markers'}; "
                             f"{'of markers give markers' if has_markers else 'of a table give columns'}")
    names = section.texts(key) or []
    if len(names) > MOST_NAMES:
        section.fault(key, f"{len(names)} names; at most {MOST_NAMES} are allowed")
    return names


def read_height(section: Section, mapping: Mapping) -> MappedHeight:
    key = "height_m" if "height_m" in section.content else "height_mm"
    section.missing(key, "above the clamp")
    factor = 1.0 if key == "height_mm" else 1e3
    height = section.number(key, 0.0, 1e5 / factor)
    millimetres = (height or 0.0) * factor
    series = "markers" if mapping.has_markers else "columns"
    section.missing(series, f"the {series} of the recording at this height; of several the mean is "
                            "taken")
    length = mapping.length_mm or math.inf
    if isinstance(length, (int, float)) and millimetres > length:
        section.fault(key, f"lies above the stem, whose length is {length:g} mm")
    if height is not None and any(other.millimetres == millimetres for other in mapping.heights):
        section.fault(key, "is given twice")
    return MappedHeight(millimetres, named_series(section, mapping.has_markers))


def read_mapping(file: Path, recording: Path | None, stem_faults: str) -> Mapping:
    """`recording` replaces the one that the mapping names. `stem_faults` are those of the tables that
    describe the stem."""
    text = file.read_bytes().decode("utf-8-sig", errors="replace")
    try:
        document = tomllib.loads(text, parse_float=WrittenNumber)
    except tomllib.TOMLDecodeError as error:
        raise Refusal(f"{file}: {error}", is_complete=True) from None
    faults = Faults(file, text)
    mapping = Mapping(document, recording or file, TextOptions(), InvalidOptions())

    def section(name: str) -> Section:
        return Section(faults, name, document.get(name, {}))
    if recording is None and "source" not in document:
        faults.add("write a table [source] with file", "source")
    read_source(section("source"), mapping, file.parent, recording)
    motion = document.get("motion", {})
    mapping.has_markers = mapping.source.suffix.lower() == ".c3d" or "axis" in motion
    if "time" not in document:
        faults.add("write a table [time] with release_s (and column for a table)", "time")
    read_time(section("time"), mapping)
    heights = document.get("height", [])
    if not mapping.sensors or heights or motion:
        if "motion" not in document:
            faults.add("write a table [motion] with zero (and unit, or axis for a C3D file)",
                       "motion")
        read_motion(section("motion"), mapping)
    mapping.clamp = named_series(section("clamp"), mapping.has_markers)
    series = "markers" if mapping.has_markers else "columns"
    if not isinstance(heights, list) or len(heights) > MOST_HEIGHTS:
        faults.add(f"height: must be tables [[height]], at most {MOST_HEIGHTS}", "height")
        heights = []
    if not heights and not mapping.sensors:
        faults.add(f"write a table [[height]] with height_mm and {series} for each height, or "
                   "[[sensor]] tables", "height")
    for index, content in enumerate(heights):
        mapping.heights.append(read_height(Section(faults, "height", content, index), mapping))
    if mapping.has_markers and mapping.sensors:
        faults.add("sensor: belongs to tables; of a C3D file give [[height]] tables", "sensor")
    faults.raise_if_any(stem_faults)
    return mapping
