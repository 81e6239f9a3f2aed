# SPDX-License-Identifier: BSD-3-Clause
"""Writes what was found in a recording as a mapping of `culm import` (docs/measurements.md).

Numbers that no recording contains are commented lines, which the user completes."""
from __future__ import annotations

import textwrap

from recording.columns import UNITS, Record, Sensor
from recording.mapping_file import toml_value
from recording.recorded_table import RecordedTable
from recording.text_form import DELIMITERS
from recording.time_stamps import UNITS as TIME_UNITS

MOST_UNUSED = 50
HEAD = """\
# A proposal of culm for `culm import`. It contains what the recording states.
# Complete the lines that begin with "# " and a key: write the value and remove the "# ".
# Check the lines that say that they are a guess.
# Readings must be positive toward the side of positive deflection.
"""
STEM = """
# length_mm =       # free length from the clamp to the tip
# density_kg_m3 =   # of the material; of a round stem as in docs/measurements.md
# diameter_mm =     # outer diameter of a round stem, instead of [section]

# [section]         # of a stem that is not round, instead of diameter_mm
# shape = "rectangle"  # "general" is described in docs/measurements.md
# width_mm =        # across the plane of motion
# height_mm =       # thickness in the direction of motion
"""


def source_lines(file: str, table: RecordedTable, record: Record) -> list[str]:
    lines = ["[source]", f"file = {toml_value(file)}"]
    if table.form is not None:
        word = next(word for word, sign in DELIMITERS.items() if sign == table.form.delimiter)
        lines.append(f'delimiter = "{word}"')
        if table.form.decimal == ",":
            lines.append('decimal = ","')
    if table.skip_lines:
        lines.append(f"skip_lines = {table.skip_lines}")
    if voltages := [toml_value(sensor.name) for sensor in record.sensors if sensor.is_voltage]:
        lines.append(f"# factors = {{ {' = 1.0, '.join(voltages)} = 1.0 }}   # per volt of the column, "
                     "from the sensor's sheet")
    return lines


def time_lines(table: RecordedTable, record: Record, repair: str | None) -> list[str]:
    lines = ["", "[time]"]
    if record.time is None and table.rate is None:
        lines.append("# rate_hz =   # samples per second: the file has no time column")
    elif record.time is None:
        lines.append(f"rate_hz = {table.rate.hertz:.12g}   # {table.rate.source}")
    else:
        guess = f"   # a guess; {', '.join(TIME_UNITS)} or frame is allowed" if record.is_unit_guess else ""
        lines += [f"column = {toml_value(record.time)}", f'unit = "{record.time_unit}"{guess}']
    if repair:
        lines.append(f'repeated_times = "{repair}"   # a guess; "spread" or "drop"')
    if record.begins_moving:
        lines += ["", "[release]",
                  'kind = "moving"   # the first readings move; else state [time] release_s']
    elif any(sensor.quantity == "displacement" for sensor in record.sensors):
        lines.append('release_s = "detect"')
    else:
        lines.append("# release_s =   # in the recording; it is detected in displacements only")
    if record.time_unit == "frame":
        lines += ["", "[camera]", f"fps = {table.rate.hertz:.12g}   # {table.rate.source}" if table.rate
                  else "# fps =   # frames per second of the recording"]
    return lines


def unit_line(sensor: Sensor) -> str:
    if sensor.unit is not None:
        scale = "   # a guess: Tracker's usual unit; the project's scale decides"
        return f'unit = "{sensor.unit}"' + (scale if sensor.is_unit_usual else "")
    what = "a reading times its factor" if sensor.is_voltage else "the column"
    return f"# unit =   # of {what}, in quotes: {', '.join(UNITS[sensor.quantity])}"


def sensor_lines(sensor: Sensor) -> list[str]:
    guess = "   # a guess: the name does not state it" if sensor.is_guess else ""
    lines = ["", "[[sensor]]", f"column = {toml_value(sensor.name)}",
             f'quantity = "{sensor.quantity}"{guess}', unit_line(sensor),
             "# height_mm =   # of the sensor above the clamp"]
    if sensor.quantity == "acceleration":
        lines.append("# mass_g =   # of the sensor, optional")
    if sensor.quantity == "strain":
        lines.append("# distance_from_axis_mm =   # of the gauge, toward positive deflection")
    return lines


def height_lines(sensors: list[Sensor]) -> list[str]:
    """The zero is that of the stem at rest."""
    if not sensors:
        return []
    pixels = '; or "px", with mm_per_px' if sensors[0].unit is None else ""
    lines = ["", "[measurement]",
             'reading = "material"   # a guess: of a marked point; "row" of a row of the picture',
             "", "[motion]", unit_line(sensors[0]) + pixels,
             'zero = "at_rest"   # a guess: the centre of the swing; before_release or as_given']
    for sensor in sensors:
        lines += ["", "[[height]]", f"columns = {toml_value(sensor.name)}",
                  "# height_mm =   # above the clamp"]
    return lines


def unused_lines(names: list[str]) -> list[str]:
    if not names:
        return []
    listed = ", ".join(toml_value(name) for name in names[:MOST_UNUSED])
    more = f" and {len(names) - MOST_UNUSED} more" if len(names) > MOST_UNUSED else ""
    return ["", *textwrap.wrap(f"Columns that are not used: {listed}{more}", 100,
                               initial_indent="# ", subsequent_indent="# ",
                               break_long_words=False)]


def mapping_text(file: str, stem: str, table: RecordedTable, record: Record,
                 repair: str | None) -> str:
    lines = source_lines(file, table, record) + time_lines(table, record, repair)
    heights = record.heights
    lines += height_lines(heights)
    for sensor in record.sensors:
        if sensor not in heights:
            lines += sensor_lines(sensor)
    lines += unused_lines(record.unused) + ["", "[stem]", f"id = {toml_value(stem)}"]
    return HEAD + "\n" + "\n".join(lines) + STEM


def keys_to_complete(table: RecordedTable, record: Record) -> str:
    quantities = {sensor.quantity for sensor in record.sensors}
    keys = ["unit"] if any(sensor.unit is None for sensor in record.sensors) else []
    keys += ["factors"] if any(sensor.is_voltage for sensor in record.sensors) else []
    keys += ["fps"] if record.time_unit == "frame" and table.rate is None else []
    keys += ["rate_hz"] if record.time is None and table.rate is None else []
    keys += [] if "displacement" in quantities or record.begins_moving else ["release_s"]
    keys.append("height_mm")
    keys += ["mass_g (optional)"] if "acceleration" in quantities else []
    keys += ["distance_from_axis_mm"] if "strain" in quantities else []
    return ", ".join(keys + ["length_mm", "density_kg_m3", "diameter_mm or [section]"])
