# SPDX-License-Identifier: BSD-3-Clause
"""`culm setup --text`: asks in a terminal for what the pictures do not show."""
from __future__ import annotations

import difflib
import json
import math
import re
from pathlib import Path

DIRECTIONS = ("decreasing_row", "increasing_row", "decreasing_column", "increasing_column")


def is_sideways(direction: str) -> bool:
    return direction.endswith("column")


def visible_length(stem: dict) -> float:
    """Length of the stem along its direction in the picture, pixels."""
    along = 0 if is_sideways(stem["up"]) else 1
    return abs(stem["clamp"][along] - stem["tip"][along])


def survey_text(data: dict) -> str:
    """A few lines on the detected stem and its release."""
    lines = [f"{data['video']}: {data['frame_count']} frames of {data['frame_width']} x "
             f"{data['frame_height']} pixels"]
    if stem := data["detected"]:
        column, row = stem["clamp"]
        lines += [f"    stem     {stem['stem']}, {stem['width_px']:.1f} pixels wide, "
                  f"{visible_length(stem):.0f} pixels long",
                  f"    clamp    row {row:.1f}, column {column:.1f}; the tip is in the direction "
                  f"{stem['up']}"]
        if stem["release_frame"] is not None:
            lines.append(f"    release  after frame {stem['release_frame']}, pulled to the "
                         f"{stem['pull_side']} by {stem['pull_px']:.1f} pixels; "
                         f"{1.0 / stem['cycles_per_frame']:.1f} frames per swing")
    lines += [f"    rate     {rate_text(data)}"]
    lines += [f"    note: {remark}" for remark in data["remarks"]]
    if data["remark"]:
        lines.append(f"    note: {data['remark']}")
    return "\n".join([*lines, *assumed_lines(data)]) + "\n"


def rate_text(data: dict) -> str:
    """The recording's rate and its source."""
    stated, first = data["stated_fps"], data["proposed_fps"]
    if data["rate_is_the_cameras"]:
        return f"{stated:.6g} frames/s, of the camera's header"
    if first:
        return f"{first:.6g} frames/s at first, of the file's time stamps"
    if stated:
        return f"{stated:.6g} frames/s, as the file states: often that of playback, not the camera's"
    return "not stated in the recording; fps is that of the camera"


def assumptions_of(data: dict) -> list[tuple[str, str]]:
    """What is taken from the pictures, with the key of [video] that states it otherwise."""
    found = []
    if data["rate_is_the_cameras"]:
        found.append((f"{data['stated_fps']:.6g} frames/s", "fps"))
    if stem := data["detected"]:
        clamp = "clamp_column" if is_sideways(stem["up"]) else "clamp_row"
        place = stem["clamp"][0 if is_sideways(stem["up"]) else 1]
        found += [(f"the tip is toward {stem['up']}", "up"),
                  (f"the stem is clamped at {clamp.removeprefix('clamp_')} {place:.1f}", clamp),
                  (f"the stem is {'brighter' if stem['stem'] == 'bright' else 'darker'} than its "
                   "background", "stem")]
        if data["bands"] > 1:
            found.append((f"the {stem['channel']} channel shows it best", "best_channel"))
        if stem["release_frame"] is not None:
            found += [(f"deflections are positive toward the {stem['pull_side']}", "pull_side"),
                      (f"it was let go after frame {stem['release_frame']}", "release_frame")]
    return found


def assumed_lines(data: dict) -> list[str]:
    return [f"    {'' if place else 'assumed:':8} {what}   ([video] {key})"
            for place, (what, key) in enumerate(assumptions_of(data))]


MASS = re.compile(r"(?P<value>[-+.\deE]+)\s*(?P<unit>|mg|g/m|material)")
MASS_KEYS = {"": "density_kg_m3", "mg": "mass_mg", "g/m": "linear_density_kg_m",
             "material": "material_density_kg_m3"}


def ask_mass(limits: dict, length: float, diameter: float) -> str:
    """The line of [stem] that gives the stem its mass."""
    def linear_density(answer: str) -> tuple[str, float, float]:
        """Key, its value, and the mass per length, g/m, from millimetres."""
        found = MASS.fullmatch(answer)
        value, area = float(found["value"]), diameter ** 2
        linear = {"": math.pi / 6.0 * area, "mg": 1e3 / length, "g/m": 1e3,
                  "material": math.pi / 4.0 * area}[found["unit"]] * value * 1e-3
        value = value * 1e-3 if found["unit"] == "g/m" else value
        return MASS_KEYS[found["unit"]], value, linear

    def fault_of(answer: str) -> str:
        try:
            linear = linear_density(answer)[2]
        except (TypeError, ValueError):
            return "must be a number, alone or with mg, g/m or material"
        density = linear / (1e-3 * math.pi / 6.0 * diameter ** 2)
        return "" if limits["from"] <= density <= limits["to"] else (
            f"is {density:.3g} kg/m³ as touching spheres; {limits['from']:g} to {limits['to']:g} "
            "is allowed")
    answer = ask("density_kg_m3 of the chain of touching spheres; or the mass of the free length, "
                 "as 81 mg, the linear density, as 1.02 g/m, or the density of the material of a "
                 "solid stem, as 7850 material", "", fault_of)
    key, value, linear = linear_density(answer)
    print(f"  {linear:.3g} g/m, {linear * length:.3g} mg on {length:g} mm")
    return f"{key} = {toml_number(value)}"


def ask(question: str, fallback: str, fault_of) -> str:
    """Asks until `fault_of` returns no fault; an empty answer takes the fallback. EOFError with the
    key of the question if the input ends."""
    while True:
        try:
            answer = input(question + (f" [{fallback}]: " if fallback else ": ")).strip() or fallback
        except EOFError as error:
            raise EOFError(question.split(" ", maxsplit=1)[0]) from error
        fault = fault_of(answer)
        if not fault:
            return answer
        print(f"  {fault}")


def ask_number(question: str, limits: dict, fallback: float | None = None) -> float:
    low, high = limits["from"], limits["to"]

    def fault_of(answer: str) -> str:
        try:
            value = float(answer)
        except ValueError:
            value = float("nan")
        is_allowed = (low < value if limits["open"] else low <= value) and value <= high
        bracket = "(" if limits["open"] else "["
        return "" if is_allowed else f"must be a number in {bracket}{low:g}, {high:.6g}]"
    return float(ask(question, "" if fallback is None else f"{fallback:.6g}", fault_of))


def fault_of_direction(answer: str) -> str:
    if answer in DIRECTIONS:
        return ""
    near = difflib.get_close_matches(answer, DIRECTIONS, 1)
    return f"must be {', '.join(DIRECTIONS)}" + (f" (did you mean {near[0]}?)" if near else "")


def fault_of_id(answer: str) -> str:
    is_allowed = re.fullmatch(r"[A-Za-z0-9._-]+", answer)
    return "" if is_allowed else "must consist of letters, digits and . _ -"


def toml_number(value: float) -> str:
    text = f"{value:.6g}"
    return text if re.search(r"[.en]", text) else text + ".0"


def ask_for_settings(data: dict) -> str:
    """The text of video.toml."""
    limits, stem = data["limits"], data["detected"]
    name = Path(data["folder"]).name
    name = ask("id of the stem", "stem" if fault_of_id(name) else name, fault_of_id)
    length = ask_number("length_mm from the clamp to the tip", limits["length_mm"])
    diameter = ask_number("diameter_mm", limits["diameter_mm"])
    mass = ask_mass(limits["density_kg_m3"], length, diameter)
    lines = [f"# written with `culm setup --text`, {data['program']}", "[video]",
             f"frames = {json.dumps(data['frames_key'], ensure_ascii=False)}"]
    if not data["rate_is_the_cameras"]:
        playback = data["stated_fps"]
        note = f" (not that of playback, {playback:.6g})" if playback else ""
        rate = ask_number("fps of the camera" + note, limits["fps"], data["proposed_fps"])
        lines.append(f"fps = {toml_number(rate)}")
    scale = length / visible_length(stem) if stem and visible_length(stem) > 0.0 else None
    question = "mm_per_px" + (" (proposed: length over visible length)" if scale else "")
    lines.append(f"mm_per_px = {toml_number(ask_number(question, limits['mm_per_px'], scale))}")
    direction = ask("up, from the clamp to the tip", stem["up"] if stem else "", fault_of_direction)
    key = "clamp_column" if is_sideways(direction) else "clamp_row"
    is_known = stem and is_sideways(direction) == is_sideways(stem["up"])
    place = stem["clamp"][0 if is_sideways(direction) else 1] if is_known else None
    lines += [f'up = "{direction}"',
              f"{key} = {toml_number(ask_number(key, limits['clamp'], place))}"]
    if stem:
        lines.append(f'stem = "{stem["stem"]}"')
    return "\n".join([*lines, "", "[stem]", f'id = "{name}"', f"length_mm = {toml_number(length)}",
                      f"diameter_mm = {toml_number(diameter)}",
                      mass, ""])
