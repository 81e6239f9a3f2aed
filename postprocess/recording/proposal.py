# SPDX-License-Identifier: BSD-3-Clause
"""Proposes a mapping for a recording: writes DIR/import.toml and prints what was found.

A recording is used where it is if it is in DIR or below, else it is copied to DIR."""
from __future__ import annotations

import shlex
import shutil
import textwrap
from pathlib import Path

import numpy as np

from recording.columns import Record, begins_moving, record_of
from recording.invalid_readings import InvalidOptions, without_invalid
from recording.printed_summary import WIDTH, assumed_lines
from recording.proposed_mapping import keys_to_complete, mapping_text
from recording.recorded_file import USUAL_UNITS, recorded_table
from recording.recorded_table import Assumption, RecordedTable
from recording.refusal import Refusal
from recording.text_table import TextOptions
from recording.time_stamps import likely_repair, rate_of, times_of
from report import write_whole

MOST_SHOWN = 4  # columns


def refuse_existing(mapping: Path):
    if mapping.exists() or mapping.is_symlink():
        raise Refusal(f"{mapping} exists and is not overwritten; complete it and run "
                      f"'{next_command(mapping)}', or remove it for a new proposal")


def next_command(mapping: Path) -> str:
    return f"culm import {shlex.quote(str(mapping))} -o {shlex.quote(str(mapping.parent))}"


def source_name(recording: Path, output: Path) -> tuple[str, bool]:
    """The recording's path as the mapping names it, and whether it must be copied there."""
    place, folder = recording.resolve(), output.resolve()
    if place.is_relative_to(folder):
        return place.relative_to(folder).as_posix(), False
    return recording.name, True


def copy_source(recording: Path, target: Path):
    if target.exists():
        if target.read_bytes() == recording.read_bytes():
            return
        raise Refusal(f"{target} exists with other content and is not overwritten; remove it or "
                      "name another folder")
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(recording, target)


def short(text: str, width: int = WIDTH) -> str:
    return text if len(text) <= width else text[:width - 1] + "…"


def extent(table: RecordedTable, record: Record, seconds: np.ndarray | None) -> str:
    if seconds is None and record.time is None:
        return f"{table.row_count} samples"
    if seconds is None:
        values = table.values(table.names.index(record.time))
        return f"{len(values)} frames, number {values[0]:g} to {values[-1]:g}"
    return f"{len(seconds)} samples, {rate_of(seconds):.5g} Hz, {seconds[-1] - seconds[0]:.5g} s"


def columns_found(record: Record) -> list[str]:
    lines = []
    for sensor in record.sensors:
        guess = " (a guess)" if sensor.is_guess else ""
        unit = f"in {sensor.unit}" if sensor.unit else "in an unknown unit"
        lines.append(f"  {short(sensor.name, 50)}: {sensor.quantity}{guess} {unit}")
    if len(lines) > MOST_SHOWN + 1:
        return lines[:MOST_SHOWN] + [f"  and {len(lines) - MOST_SHOWN} more columns"]
    return lines


def summary(recording: Path, mapping: Path, table: RecordedTable, record: Record,
            seconds: np.ndarray | None, assumptions: list[Assumption]) -> list[str]:
    motion = "The record begins at rest: the release will be detected."
    if record.begins_moving:
        motion = "The record begins in motion: the release was not recorded."
    elif all(sensor.quantity != "displacement" for sensor in record.sensors):
        motion = "The record begins at rest: state the time of the release."
    complete = textwrap.wrap(f"Fill in the commented lines: {keys_to_complete(table, record)}.", WIDTH)
    if record.time is None:
        time = "  no time column" + ("" if table.rate else ": the rate must be stated")
    else:
        guess = " (a guess)" if record.is_unit_guess else ""
        title = table.titles[table.names.index(record.time)]
        name = f'column {record.time}, "{title}"' if title != record.time else record.time
        time = f"  {short(name, 50)}: time in {record.time_unit}{guess}"
    return [f"{short(recording.name, 40)}: {extent(table, record, seconds)}", time,
            *columns_found(record), *assumed_lines(assumptions), *map(short, table.notes), motion,
            f"Written: {mapping}", *complete, f"Then run: {next_command(mapping)}"]


def time_assumptions(table: RecordedTable,
                     record: Record) -> tuple[np.ndarray | None, str | None, list[Assumption]]:
    """Times, the repair of stamps that repeat, and what was assumed."""
    k = table.names.index(record.time) if record.time is not None else None
    if record.time_unit == "frame" and table.rate:
        return None, None, [Assumption(f"{table.rate.hertz:g} frames/s: {table.rate.source}",
                                       "[camera] fps")]
    if record.time_unit == "frame" or (k is None and table.rate is None):
        return None, None, []
    rate = table.rate.hertz if table.rate else None
    if k is None:
        seconds = times_of(table, None, "s", table.rate.hertz, None)[0].seconds
        return seconds, None, [Assumption(f"{table.rate.hertz:g} samples/s: {table.rate.source}",
                                          "[time] rate_hz")]
    repair = likely_repair(table.columns[k]) if table.is_numeric(k) else None
    times, assumed = times_of(table, k, record.time_unit, rate, repair)
    if record.is_unit_guess:
        assumed.insert(0, Assumption(f'times are in {record.time_unit}, which the name '
                                     f'"{table.titles[k]}" does not state', "[time] unit"))
    return times.seconds, repair, assumed


def propose(recording: Path, output: Path) -> list[str]:
    mapping = output / "import.toml"
    refuse_existing(mapping)
    kind = recording.suffix.lower()
    if kind == ".c3d":
        raise Refusal("a C3D file needs a mapping that names its markers; copy and complete "
                      "config/measurements/c3d.toml")
    table = recorded_table(recording, TextOptions(), [])
    record = record_of(table, USUAL_UNITS.get(kind), recording.stem)
    seconds, repair, assumed = time_assumptions(table, record)
    columns, more, _ = without_invalid(table, [sensor.name for sensor in record.sensors],
                                       InvalidOptions())
    record.begins_moving = begins_moving(columns)
    name, must_copy = source_name(recording, output)
    content = mapping_text(name, recording.stem, table, record, repair)
    if must_copy:
        copy_source(recording, output / name)
    write_whole(mapping, content)
    return summary(recording, mapping, table, record, seconds, table.assumptions + assumed + more)
