# SPDX-License-Identifier: BSD-3-Clause
"""Writes an imported recording as a measurement folder: stem.toml and deflection.csv."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from recording.mapping_file import KEYS, Mapping, toml_value
from recording.measured_rows import Measured, Row
from report import write_whole

ORDER = ["stem", "section", "added_mass", "sensor", "release", "camera", "measurement"]


def number_text(value: float) -> str:
    """The shortest decimals that read back bit for bit."""
    return repr(float(value)).removesuffix(".0")


def column_name(row: Row) -> str:
    return row.sensor["column"] if row.sensor is not None else f"h={number_text(row.millimetres)}mm"


def quoted_cell(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(c in name for c in '",\n') else name


def deflection_text(measured: Measured) -> str:
    """Deflections are rounded to 1 nm, times to 1 ns: further digits are rounding errors."""
    header = ",".join(["time_s", *(quoted_cell(column_name(row)) for row in measured.rows)])
    columns = [[number_text(time) for time in measured.times]]
    for row in measured.rows:
        values = np.round(row.values, 6) if row.sensor is None else row.values
        columns.append(["" if value != value else number_text(value) for value in values.tolist()])
    return "\n".join([header, *map(",".join, zip(*columns))]) + "\n"


def table_text(name: str, content: dict, is_list: bool) -> str:
    lines = [f"[[{name}]]" if is_list else f"[{name}]"]
    return "\n".join(lines + [f"{key} = {toml_value(value)}" for key, value in content.items()])


def stem_document(mapping: Mapping, measured: Measured) -> dict:
    """The mapping's tables on the stem, with what was found in the recording."""
    document = {name: content for name, content in mapping.document.items() if name not in KEYS}
    for name in ("release", "camera", "measurement"):
        document[name] = dict(document.get(name, {}))
    if measured.release_uncertainty is not None:
        document["release"].setdefault("time_uncertainty_ms",
                                       float(f"{1e3 * measured.release_uncertainty:.3g}"))
    start = document["release"].get("start_s")
    if start is not None and start >= 1e6:
        document["release"]["start_s"] = round(float(start) - measured.origin, 9)
    if mapping.has_markers and "fps" not in document["camera"] and len(measured.times) > 1:
        rate = (len(measured.times) - 1) / (measured.times[-1] - measured.times[0])
        document["camera"]["fps"] = round(float(rate), 6)
    if measured.noise_source:
        write_noise(document, measured)
    return document


def write_noise(document: dict, measured: Measured):
    heights = [row for row in measured.rows if row.sensor is None]
    if len(heights) == len(measured.rows):
        document["measurement"]["noise_by_height_mm"] = [float(f"{row.noise:.6g}")
                                                          for row in heights]
    else:  # each sensor states its own; heights between them have one noise
        if heights:
            document["measurement"]["noise_mm"] = float(f"{max(r.noise for r in heights):.6g}")
        noise = {row.sensor["column"]: row.noise for row in measured.rows if row.sensor is not None}
        document["sensor"] = [dict(sensor, noise=sensor.get("noise",
                                                            float(f"{noise[sensor['column']]:.6g}")))
                              for sensor in document["sensor"]]
    document["measurement"].setdefault("noise_source", measured.noise_source)


def stem_text(document: dict) -> str:
    parts = []
    for name in sorted(document, key=lambda name: ORDER.index(name) if name in ORDER else 99):
        content = document[name]
        if isinstance(content, list):
            parts += [table_text(name, entry, True) for entry in content]
        elif content:
            parts.append(table_text(name, content, False))
    return "\n\n".join(parts) + "\n"


def write_measurement(folder: Path, mapping: Mapping, measured: Measured):
    write_whole(folder / "stem.toml", stem_text(stem_document(mapping, measured)))
    write_whole(folder / "deflection.csv", deflection_text(measured))
    (folder / "uncertainty.csv").unlink(missing_ok=True)  # of an earlier measurement
