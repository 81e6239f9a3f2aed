# SPDX-License-Identifier: BSD-3-Clause
"""Turns the columns that a mapping names into the rows of a measurement: deflections at heights in
mm, readings of sensors in their own unit, times from the release."""
from __future__ import annotations

import difflib
import json
import math
import subprocess
from dataclasses import dataclass, field

import numpy as np

from recording.averaged_rows import average_down
from recording.columns import contradiction
from recording.invalid_readings import without_invalid
from recording.mapping_file import MOTION_UNITS, Mapping
from recording.recorded_table import Assumption, RecordedTable, counted
from recording.refusal import Refusal
from recording.time_stamps import Times, rate_of, times_of

FEWEST_FRAMES_FOR_NOISE = 8
SWING_SHARE = 0.05  # held frames scatter by less than this share of the scatter after the release
SURELY_CORRELATED = 4.9  # standard deviations of von Neumann's ratio: by chance one in a million


@dataclass
class Row:
    """One height or one sensor. `sensor` is its table in the mapping; None for a height."""
    millimetres: float
    values: np.ndarray
    sensor: dict | None = None
    noise: float | None = None

    @property
    def unit(self) -> str:
        return "mm" if self.sensor is None else self.sensor["unit"]

    @property
    def is_position(self) -> bool:
        return self.sensor is None or self.sensor["quantity"] == "displacement"


@dataclass
class Measured:
    times: np.ndarray  # s from the release
    rows: list[Row]
    release: float = 0.0
    origin: float = 0.0  # of the source's clock, which is subtracted from stated times
    held_begin: float = -math.inf  # of the hold before the release
    release_uncertainty: float | None = None
    noise_source: str = ""
    assumptions: list[Assumption] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def is_held(self) -> np.ndarray:
        return (self.times >= self.held_begin) & (self.times < self.release)


def unknown_name(kind: str, name: str, valid: list[str]) -> Refusal:
    near = difflib.get_close_matches(name, valid, 1, 0.5)
    hint = f' (did you mean "{near[0]}"?)' if near else ""
    listed = '", "'.join(valid[:20])
    return Refusal(f'there is no {kind} "{name}"{hint}; it has "{listed}"')


def column_index(table: RecordedTable, name: str) -> int:
    """A column by its name, or else by its number from 1."""
    if name in table.names:
        return table.names.index(name)
    if name.isdigit() and 1 <= int(name) <= len(table.names):
        return int(name) - 1
    raise unknown_name("column", name, table.names)


def marker_columns(table: RecordedTable, name: str) -> list[str]:
    columns = [f"{name} {axis}" for axis in "xyz"]
    if all(column in table.names for column in columns):
        return columns
    markers = [column[:-2] for column in table.names if column.endswith(" x")]
    raise unknown_name("marker", name, markers)


def series_of(table: RecordedTable, mapping: Mapping,
              kept: np.ndarray) -> tuple[dict[str, np.ndarray], list[Assumption], list[str]]:
    """Each named column or marker in mm, those of sensors in their unit, without invalid readings."""
    names = mapping.names_used()
    columns = {name: marker_columns(table, name) if mapping.has_markers
               else [table.names[column_index(table, name)]] for name in names}
    used = list(dict.fromkeys(column for parts in columns.values() for column in parts))
    for column in used:
        if not table.is_numeric(table.names.index(column)):
            raise Refusal(f'column "{column}" contains text, such as '
                          f'"{str(table.columns[table.names.index(column)][0])[:30]}"')
    values, assumed, notes = without_invalid(table, used, mapping.invalid)
    for name, factor in mapping.factors.items():
        column = table.names[column_index(table, name)]
        if column not in values:
            raise Refusal(f'[source] factors: column "{column}" is not used; remove it')
        values[column] = factor * values[column]
    notes += unit_notes(table, mapping)
    sensors = {sensor["column"] for sensor in mapping.sensors}
    factor = MOTION_UNITS[mapping.unit] * mapping.mm_per_px * mapping.sign
    series = {}
    for name, parts in columns.items():
        if mapping.has_markers:
            place = np.array([values[column] for column in parts])
            unseen = np.all(place == 0.0, axis=0)
            if np.any(unseen) and not np.all(unseen):
                place[:, unseen] = np.nan
                assumed.append(Assumption(
                    f'marker "{name}": {counted(int(unseen.sum()), "position")} at 0, 0, 0 '
                    f"({table.where(np.flatnonzero(unseen))}) were not seen",
                    "[source] missing_values"))
            series[name] = 1e3 * (np.array(mapping.axis) @ place)[kept]
        else:
            value = values[parts[0]][kept]
            series[name] = value if name in sensors else factor * value
    return series, assumed, notes


def unit_notes(table: RecordedTable, mapping: Mapping) -> list[str]:
    """Columns whose unit in the file is not that of the mapping."""
    if mapping.has_markers:
        return []
    stated = {name: mapping.unit for name in mapping.names_used()} | {
        sensor["column"]: sensor["unit"] for sensor in mapping.sensors}
    notes = [contradiction(table, column_index(table, name), unit) for name, unit in stated.items()
             if name not in mapping.factors]
    return [note for note in notes if note]


def mean_of(series: dict[str, np.ndarray], names: list[str]) -> np.ndarray:
    """NaN where one has a gap, because the mean of the others would jump."""
    return sum(series[name] for name in names) / len(names)


def rows_of(mapping: Mapping, series: dict[str, np.ndarray]) -> list[Row]:
    """From the lowest height up."""
    clamp = 0.0
    if mapping.clamp:
        clamp = mean_of(series, mapping.clamp)
        seen = clamp[np.isfinite(clamp)]
        clamp = clamp - (seen[0] if seen.size else 0.0)
    rows = [Row(height.millimetres, mean_of(series, height.names) - clamp)
            for height in mapping.heights]
    for sensor in mapping.sensors:
        height = sensor.get("height_mm", 1e3 * sensor.get("height_m", 0.0))
        rows.append(Row(float(height), series[sensor["column"]].copy(), sensor,
                        sensor.get("noise")))
    return sorted(rows, key=lambda row: row.millimetres)


def ask_release(program: str, times: np.ndarray, rows: list[Row], length_mm: float,
                release: float | str | None) -> dict:
    """The release and the centres of the swings, of the program that also reads videos."""
    def share_seen(row: Row) -> float:
        return float(np.mean(np.isfinite(row.values)))
    best = max(share_seen(row) for row in rows)
    watched = max((k for k, row in enumerate(rows) if share_seen(row) > best - 0.05),
                  key=lambda k: rows[k].millimetres)
    request = {"samples": len(times), "watched": watched, "release": release,
               "relative_heights": [min(1.0, row.millimetres / length_mm) for row in rows]}
    content = b"".join(np.ascontiguousarray(values, float).tobytes()
                       for values in (times, *(row.values for row in rows)))
    done = subprocess.run([program, "release"], input=json.dumps(request).encode() + b"\n" + content,
                          capture_output=True, check=False)
    if done.returncode != 0:
        raise Refusal(done.stderr.decode(errors="replace").strip().removeprefix("culm: ")
                      or f"{program} ended with {done.returncode}")
    return json.loads(done.stdout)


def find_release(measured: Measured, mapping: Mapping, program: str):
    """Sets time 0, and subtracts the zero of the deflections at heights."""
    positions = [row for row in measured.rows if row.is_position]
    wanted = mapping.release
    if isinstance(wanted, (int, float)):
        wanted = float(wanted) - (measured.origin if wanted >= 1e6 else 0.0)
        measured.release = wanted
    if wanted == "detect" and not positions:
        raise Refusal("a release is detected in displacements only; set [time] release_s")
    is_asked = wanted == "detect" or (mapping.zero == "at_rest" and mapping.heights)
    answer = (ask_release(program, measured.times, positions, mapping.length_mm or 1e3, wanted)
              if is_asked else {})
    if wanted == "detect":
        if "reason" in answer:
            raise Refusal(f'{answer["reason"]}. Set [time] release_s, or [release] kind = "moving"')
        found = answer["release"]
        measured.release, measured.release_uncertainty = found["time"], found["uncertainty"]
        measured.held_begin = found["held_begin"]
        measured.assumptions.append(Assumption(
            f"the stem was released at {to_digits_of(found['time'], found['uncertainty'])} s ± "
            f"{two_digits(1e3 * found['uncertainty'])} ms (standard uncertainty), the last time "
            "that it leaves a rest away from its final position", "[time] release_s"))
    subtract_zero(measured, mapping, dict(zip(map(id, positions), answer.get("centres", []))))


def subtract_zero(measured: Measured, mapping: Mapping, centres: dict[int, float]):
    heights = [row for row in measured.rows if row.sensor is None]
    held = measured.is_held() if mapping.release is not None else None
    for row in heights:
        if mapping.zero == "before_release":
            if held is None or not np.any(np.isfinite(row.values[held])):
                raise Refusal("no frame lies before the release, so there is no zero: set [motion] "
                              'zero = "at_rest" or "as_given"')
            row.values = row.values - np.nanmean(row.values[held])
        elif mapping.zero == "at_rest":
            if centres.get(id(row)) is None:
                raise Refusal(f"no reading at {row.millimetres:g} mm, so there is no zero")
            row.values = row.values - centres[id(row)]
        else:
            note_far_centre(measured, row)


def note_far_centre(measured: Measured, row: Row):
    """A swing about a position far from 0 means that the zero is not that of the stem at rest."""
    late = row.values[len(row.values) // 2:]
    late = late[np.isfinite(late)]
    if late.size < 12:
        return
    centre = 0.5 * (np.quantile(late, 0.02) + np.quantile(late, 0.98))
    swing = np.nanmax(row.values) - np.nanmin(row.values)
    if abs(centre) > 0.25 * swing:
        measured.notes.append(
            f"the stem swings about {centre:.3g} mm at {row.millimetres:g} mm, not about 0: if the "
            'deflections do not count from the undeformed stem, set [motion] zero = "at_rest"')


def two_digits(value: float) -> str:
    """A number with two significant digits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    decimals = max(0, 1 - math.floor(math.log10(abs(value))))
    return f"{round(value, decimals):.{decimals}f}"


def to_digits_of(value: float, uncertainty: float) -> str:
    """A number with as many digits as its uncertainty with two significant ones."""
    return f"{value:.{max(0, 1 - math.floor(math.log10(uncertainty)))}f}"


def moves(values: np.ndarray, held: np.ndarray) -> bool:
    """Does the stem move in the held frames? White noise has steps with twice its variance; a
    resolved motion has smaller steps (von Neumann 1941: the ratio is 2 ± 2/√n)."""
    before, after = values[held], values[np.flatnonzero(held)[-1] + 1:] if np.any(held) else values
    before, after = before[np.isfinite(before)], after[np.isfinite(after)]
    if before.size < FEWEST_FRAMES_FOR_NOISE or not after.size > 1:
        return False
    if not np.std(before, ddof=1) > SWING_SHARE * np.std(after, ddof=1):
        return False
    steps = np.diff(values[held])
    steps = steps[np.isfinite(steps)]
    ratio = np.mean(steps ** 2) / np.var(before, ddof=1)
    return bool(2.0 - ratio > SURELY_CORRELATED * 2.0 / math.sqrt(steps.size))


def estimate_noise(measured: Measured, mapping: Mapping):
    """Unless the mapping states a noise, it is the scatter before the release."""
    held = measured.is_held()
    count = int(held.sum())
    if any(moves(row.values, held) for row in measured.rows):
        zero = (', and their mean is not a valid zero: set zero = "at_rest" or "as_given"'
                if mapping.zero == "before_release" else "")
        measured.notes.append(
            f"the stem moves in the {counted(count, 'frame')} before the release: the recording begins "
            'in the middle of a swing (then write [release] kind = "moving"), it contains the pull, '
            f"or release_s is wrong. No noise is estimated from these frames{zero}")
        return
    stated = mapping.document.get("measurement", {})
    if any(key.startswith("noise") and key not in ("noise_source", "noise_correlation")
           for key in stated) or all(row.noise is not None for row in measured.rows):
        return
    scatter = []
    for row in measured.rows:
        before = row.values[held]
        before = before[np.isfinite(before)]
        scatter.append((before.size, np.std(before, ddof=1) if before.size > 1 else 0.0))
    fewest = min(size for size, _ in scatter)
    if fewest < FEWEST_FRAMES_FOR_NOISE or any(
            value <= 1e-9 * np.nanmax(np.abs(row.values)) for row, (_, value)
            in zip(measured.rows, scatter)):
        measured.notes.append(f"the noise cannot be estimated from {counted(count, 'frame')} before "
                              "the release; set [measurement] noise_mm")
        return
    for row, (_, value) in zip(measured.rows, scatter):
        row.noise = row.noise if row.noise is not None else float(value)
    measured.noise_source = f"scatter of {fewest} frames before the release"


def keep_frames(measured: Measured, mapping: Mapping):
    """Times from the release; the frames that the mapping keeps."""
    times = np.round(measured.times - measured.release, 9)
    kept = np.ones(len(times), bool)
    if mapping.before is not None:
        kept &= times >= -mapping.before
    if mapping.after is not None:
        kept &= times <= mapping.after
    if not np.any(kept) or times[kept][-1] <= 0.0:
        raise Refusal(f"nothing was recorded after the release at {measured.release:g} s")
    measured.times = times[kept]
    for row in measured.rows:
        row.values = row.values[kept]


def measured_rows(table: RecordedTable, mapping: Mapping, program: str) -> Measured:
    """`program` is culm-track."""
    column = None
    if mapping.time_column is not None:
        column = column_index(table, mapping.time_column)
    rate = mapping.rate_hz or mapping.fps
    times, assumed = times_of(table, column, mapping.time_unit, rate, mapping.repeated_times)
    series, more, notes = series_of(table, mapping, times.kept)
    measured = Measured(times.seconds, rows_of(mapping, series), origin=float(times.origin),
                        assumptions=table.assumptions + assumed + more, notes=table.notes + notes)
    if len(measured.times) < 3:
        raise Refusal("it has fewer than three samples")
    describe_rate(measured, mapping, times)
    find_release(measured, mapping, program)
    average_down(measured, mapping)
    if mapping.release is not None:
        estimate_noise(measured, mapping)
    else:
        measured.release = 0.0
    keep_frames(measured, mapping)
    return measured


def describe_rate(measured: Measured, mapping: Mapping, times: Times):
    if mapping.rate_hz is not None:
        return
    if mapping.time_unit == "frame":
        source = f"frame numbers at the stated {mapping.fps:g} frames/s"
    elif mapping.has_markers:
        source = "of the file's header"
    else:
        source = f'mean step of "{mapping.time_column}" in {mapping.time_unit}'
    key = "[camera] fps" if mapping.time_unit == "frame" else "[time] unit, or rate_hz"
    measured.assumptions.insert(
        0, Assumption(f"{rate_of(times.seconds):.6g} samples/s: {source}", key))
