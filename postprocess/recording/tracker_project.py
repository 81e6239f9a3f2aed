# SPDX-License-Identifier: BSD-3-Clause
"""Reads the tracks of a project of the video program Tracker (.trk, XML; or .trz, which is the
project, its video and other files in one zip file)."""
from __future__ import annotations

import math
import re
import zipfile
import zlib
from bisect import bisect_right
from pathlib import Path
from xml.etree import ElementTree as xml

from recording.refusal import Refusal, Table

TRACKER = "org.opensourcephysics.cabrillo.tracker."
MOST_FRAMES = 1_000_000
LARGEST_PROJECT = 200_000_000  # bytes, unpacked


class WithoutDoctype(xml.TreeBuilder):
    def doctype(self, *_):
        raise Refusal("it declares a document type or entities; Tracker's projects have none")


def member(owner: xml.Element | None, name: str) -> xml.Element | None:
    """The object, or else the property itself, of an object's property."""
    found = None if owner is None else owner.find(f"property[@name='{name}']")
    inner = None if found is None else found.find("object")
    return found if inner is None else inner


def number(owner: xml.Element | None, name: str, absent: float | None = None) -> float:
    found = member(owner, name)
    if found is None:
        if absent is None:
            raise Refusal(f"the project lacks '{name}'; Tracker writes one in every project")
        return absent
    value = float(found.text or "")
    if not math.isfinite(value):
        raise ValueError(f"'{name}' is {value}")
    return value


def whole_number(owner: xml.Element | None, name: str, absent: int, least: int) -> int:
    value = number(owner, name, absent)
    if not least <= value <= MOST_FRAMES:
        raise Refusal(f"'{name}' is {value:g}; {least} to {MOST_FRAMES} is allowed")
    return int(value)


def by_frame(owner: xml.Element | None) -> dict[int, xml.Element]:
    """The objects of the array `framedata`, whose indices are frame numbers of the video."""
    data = member(owner, "framedata")
    found = {int(entry.get("name", "").strip("[]")): entry.find("object")
             for entry in (() if data is None else data.findall("property[object]"))}
    return dict(sorted(found.items()))


def in_project_axes(x: float, y: float, axes: xml.Element) -> tuple[float, float]:
    """Undoes what maps project axes to the picture: rotation, scale, y downwards, origin."""
    angle = math.radians(number(axes, "angle"))
    right = (x - number(axes, "xorigin")) / number(axes, "xscale")
    up = (number(axes, "yorigin") - y) / number(axes, "yscale")
    return (math.cos(angle) * right + math.sin(angle) * up,
            math.cos(angle) * up - math.sin(angle) * right)


def positions(track: xml.Element, axes: dict[int, xml.Element]) -> dict[int, tuple[float, float]]:
    """A point's position in every frame that has one, in the axes last set before or in it."""
    changes = list(axes)
    return {frame: in_project_axes(number(place, "x"), number(place, "y"),
                                   axes[changes[max(bisect_right(changes, frame) - 1, 0)]])
            for frame, place in by_frame(track).items()}


def frame_times(panel: xml.Element, frames: list[int]) -> list[float]:
    """Times in s. If a video's frames last unequally long, the project has their times, which
    Tracker stretches to the project's mean frame time."""
    clip, control = member(panel, "videoclip"), member(panel, "clipcontrol")
    video = member(clip, "video")
    mean = number(video if member(control, "delta_t") is None else control, "delta_t")
    begin, first = number(clip, "starttime", 0.0), whole_number(clip, "startframe", 0, 0)
    texts = member(member(video, "start_times"), "array")
    own = [] if texts is None else [float(t) for t in re.findall(r"[^{},\s]+", texts.text or "")]
    if mean <= 0.0:
        raise Refusal(f"a frame lasts {mean:g} ms; a time above 0 is allowed")
    if len(own) > max(frames[-1], 1):
        usual = (own[-1] - own[0]) / (len(own) - 1)
        if any(abs(b - a - usual) > 0.01 * usual for a, b in zip(own, own[1:])):
            return [(begin + (own[n] - own[first]) * mean / usual) / 1e3 for n in frames]
    return [(begin + (n - first) * mean) / 1e3 for n in frames]


def project_text(source: Path) -> bytes:
    """The project itself; a .trz file must contain one."""
    if source.suffix.lower() != ".trz":
        return source.read_bytes()
    try:
        with zipfile.ZipFile(source) as archive:
            projects = [entry for entry in archive.infolist()
                        if entry.filename.lower().endswith(".trk")]
            if len(projects) != 1:
                names = ", ".join(entry.filename for entry in projects[:8]) or "none"
                raise Refusal(f"it contains {len(projects)} projects ({names}); one is allowed: "
                              "unpack it (it is a zip file) and import the project .trk")
            if projects[0].file_size > LARGEST_PROJECT:
                raise Refusal(f"its project has {projects[0].file_size} bytes; {LARGEST_PROJECT} "
                              "are allowed")
            return archive.read(projects[0])
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError) as error:
        raise Refusal(f"it is not a whole zip file ({error}), which a .trz is") from None


def tracker_table(source: Path) -> Table:
    try:
        panel = xml.fromstring(project_text(source), xml.XMLParser(target=WithoutDoctype()))
    except (xml.ParseError, ValueError, LookupError) as error:
        raise Refusal(f"it is not XML ({error}); a project of Tracker is allowed") from None
    if panel.get("class") != TRACKER + "TrackerPanel":
        raise Refusal("it is not a project of Tracker; save the project of one video as .trk")
    try:
        return columns_of_project(panel)
    except (ValueError, ZeroDivisionError, IndexError, OverflowError) as error:
        raise Refusal(f"it has a number that Tracker does not write ({error}); finite numbers, "
                      "scales above 0 and frames from [0] are allowed") from None


def columns_of_project(panel: xml.Element) -> Table:
    axes, clip = by_frame(member(panel, "coords")), member(panel, "videoclip")
    if not axes:
        raise Refusal("it has no coordinate system; Tracker writes one in every project")
    points = panel.findall(
        f"property[@name='tracks']/property/object[@class='{TRACKER}PointMass']")
    tracks = [positions(point, axes) for point in points]
    names = [" ".join(point.findtext("property[@name='name']", "").split()) for point in points]
    marked = sorted(frame for track in tracks for frame in track)
    first, step = whole_number(clip, "startframe", 0, 0), whole_number(clip, "stepsize", 1, 1)
    end = first + step * whole_number(clip, "stepcount", MOST_FRAMES, 1)
    frames = [n for n in range(first, min(end, MOST_FRAMES), step)
              if marked and marked[0] <= n <= marked[-1]]
    if not frames:
        raise Refusal("no point mass has a position in the clip's frames; track one point or more")
    return [("t", frame_times(panel, frames))] + [
        (f"{name} {axis}", [track[n][k] if n in track else None for n in frames])
        for name, track in zip(names, tracks) for k, axis in enumerate("xy")]
