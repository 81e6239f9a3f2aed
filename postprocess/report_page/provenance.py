# SPDX-License-Identifier: BSD-3-Clause
"""The member `provenance` of the JSON documents as facts for the page."""
from __future__ import annotations

from report_page.markup import shown

MOST_FILES = 8


def provenance_rows(content: dict) -> list[list]:
    """Names and texts; none of a document of a culm that did not write them yet."""
    known = content.get("provenance")
    if not known:
        return []
    ranks = f"{known['ranks']} rank{'' if known['ranks'] == 1 else 's'}"
    rows = [["command", known["command"]],
            ["written by", f"{known['version']}, {known['date'].replace('T', ' ').rstrip('Z')} UTC"],
            ["time", f"{shown(known['wall_s'], 3)} s on {ranks}, {shown(known['processor_s'], 3)} s "
                     "of processor time"],
            ["build", f"{known['compiler']}, {known['build']}; {known['libraries']}"]]
    rows += [["input", f"{entry['file']}: {_size(entry)}"] for entry in known["inputs"][:MOST_FILES]]
    if len(known["inputs"]) > MOST_FILES:
        rows.append(["inputs", f"{len(known['inputs']) - MOST_FILES} more"])
    return rows


def _size(entry: dict) -> str:
    if entry["bytes"] is None:
        return "could not be read again"
    return f"{entry['bytes']} bytes, CRC-32 {entry['crc32']}"
