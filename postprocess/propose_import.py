#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Proposes a mapping for `culm import`: propose_import.py RECORDING --output DIR.

It looks at a recording and writes DIR/import.toml. A text table is used where it is if it is in DIR
or below, else it is copied to DIR. A .trk, .mat, .npy or .npz is converted to DIR/recording.csv
(recording_table.py). Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

import argparse
import shlex
import sys
import textwrap
from pathlib import Path
from statistics import median

import recording_table
from delimited_table import DelimitedTable, table_of, text_of
from import_mapping import keys_to_complete, mapping_text
from recorded_columns import SECONDS, Record, record_of
from recording_refusal import Refusal, exit_code_of
from report import write_whole

WIDTH = 100
MOST_SHOWN = 4  # columns; 12 lines are printed at most


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, usage="%(prog)s RECORDING --output DIR",
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", metavar="RECORDING", type=Path)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True)
    return parser.parse_args(arguments)


def refuse_existing(mapping: Path):
    if mapping.exists() or mapping.is_symlink():
        raise Refusal(f"{mapping} exists and is not overwritten; complete it and run "
                      f"'{next_command(mapping)}', or remove it for a new proposal")


def next_command(mapping: Path) -> str:
    return f"culm import {shlex.quote(str(mapping))} -o {shlex.quote(str(mapping.parent))}"


def is_converted(recording: Path) -> bool:
    return recording.suffix.lower() in recording_table.READERS


def table_text(recording: Path) -> str:
    """The recording as a text table."""
    if recording.suffix.lower() == ".c3d":
        raise Refusal("a C3D file needs a mapping that names its markers; copy and complete "
                      "config/measurements/c3d.toml")
    if is_converted(recording):
        reader = recording_table.READERS[recording.suffix.lower()]
        return recording_table.table_text(reader(recording))
    return text_of(recording)


def source_name(recording: Path, output: Path) -> tuple[str, bool]:
    """The table's path as the mapping names it, and whether the table must be written there."""
    if is_converted(recording):
        return "recording.csv", True
    place, folder = recording.resolve(), output.resolve()
    if place.is_relative_to(folder):
        return place.relative_to(folder).as_posix(), False
    return recording.name, True


def write_source(recording: Path, text: str, target: Path):
    content = text.encode("utf-8") if is_converted(recording) else recording.read_bytes()
    if target.exists():
        if target.read_bytes() == content:
            return
        raise Refusal(f"{target} exists with other content and is not overwritten; remove it or "
                      "name another folder")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)


def short(text: str, width: int = WIDTH) -> str:
    return text if len(text) <= width else text[:width - 1] + "…"


def extent(record: Record) -> str:
    times = record.times
    if record.time_unit == "frame":
        return f"{len(times)} frames, number {times[0]:g} to {times[-1]:g}"
    second = SECONDS[record.time_unit]
    rate = 1.0 / (second * median(b - a for a, b in zip(times, times[1:])))
    return f"{len(times)} samples, {rate:.5g} Hz, {second * (times[-1] - times[0]):.5g} s"


def columns_found(record: Record) -> list[str]:
    lines = []
    for sensor in record.sensors:
        guess = " (a guess)" if sensor.is_guess else ""
        unit = f"in {sensor.unit}" if sensor.unit else "in an unknown unit"
        lines.append(f"  {short(sensor.name, 50)}: {sensor.quantity}{guess} {unit}")
    if len(lines) > MOST_SHOWN + 1:
        return lines[:MOST_SHOWN] + [f"  and {len(lines) - MOST_SHOWN} more columns"]
    return lines


def summary(recording: Path, mapping: Path, table: DelimitedTable, record: Record) -> list[str]:
    where = f", lines ahead of the table: {table.skip_lines}" if table.skip_lines else ""
    motion = ("The record begins in motion: the release was not recorded." if record.begins_moving
              else "The record begins at rest: the release will be detected.")
    complete = textwrap.wrap(f"Fill in the commented lines: {keys_to_complete(record)}.", WIDTH)
    return [f"{short(recording.name, 40)}: {extent(record)}{where}",
            f"  {short(record.time, 50)}: time in {record.time_unit}"
            + (" (a guess)" if record.is_unit_guess else ""),
            *columns_found(record), motion, f"Written: {mapping}", *complete,
            f"Then run: {next_command(mapping)}"]


def propose(recording: Path, output: Path) -> list[str]:
    mapping = output / "import.toml"
    refuse_existing(mapping)
    text = table_text(recording)
    table = table_of(text)
    record = record_of(table, "m" if recording.suffix.lower() == ".trk" else None)
    name, must_write = source_name(recording, output)
    content = mapping_text(name, recording.stem, table, record)
    if must_write:
        write_source(recording, text, output / name)
    write_whole(mapping, content)
    return summary(recording, mapping, table, record)


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    return exit_code_of(options.recording,
                        lambda: print("\n".join(propose(options.recording, options.output))))


if __name__ == "__main__":
    sys.exit(main())
