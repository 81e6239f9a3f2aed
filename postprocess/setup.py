#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sets up a recording for `culm track`: writes DIR/setup.html, or asks in the terminal.

`culm setup` calls this program (docs/tracking.md). What is in the pictures is found by
`culm-track survey`. The page works without a network; a person saves video.toml with it. Exit codes:
0 done, 2 bad input or something missing on this machine.
"""
from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from collections import Counter
from pathlib import Path

from report import write_whole
from setup_page.dialogue import ask_for_settings, assumptions_of, survey_text

EXIT_BAD_INPUT = 2
PAGE = Path(__file__).resolve().parent / "setup_page"
PICTURES = {".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".webp"}


class Refusal(Exception):
    """The input is bad; the text is the reason."""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="culm setup", description=__doc__.splitlines()[0])
    parser.add_argument("video", metavar="VIDEO")
    parser.add_argument("--output", metavar="DIR", type=Path, required=True)
    parser.add_argument("--text", action="store_true")
    parser.add_argument("--culm-track", metavar="PROGRAM", default="culm-track")
    parser.add_argument("--program", metavar="VERSION", default="culm")
    return parser.parse_args(arguments)


def pattern_of(name: str) -> str | None:
    """"run_%04d.png" for "run_0007.png"; nothing for a name without a number before its suffix."""
    found = re.fullmatch(r"(.*?)(\d+)(\.\w+)", name)
    if not found or Path(name).suffix.lower() not in PICTURES:
        return None
    before, digits, suffix = found.groups()
    is_padded = digits.startswith("0") and len(digits) > 1
    return f"{before}%{f'0{len(digits)}' if is_padded else ''}d{suffix}"


def recording_location(named: str) -> Path:
    """A video file, a Photron header or a pattern; of a folder the pattern of most pictures."""
    place = Path(named)
    if place.is_dir():
        patterns = Counter(filter(None, (pattern_of(entry.name) for entry in place.iterdir())))
        if not patterns:
            raise Refusal(f"{named}: the folder has no numbered pictures; name a video file, a "
                          "Photron header (.cih) or a pattern like frames/%05d.png")
        return place / max(sorted(patterns), key=patterns.get)
    if "%" not in place.name and not place.exists():
        raise Refusal(f"{named}: there is no such file or folder")
    return place


def require_free(folder: Path, location: Path):
    """Refuses, before any work, a folder with a video.toml or with other pictures."""
    if os.path.lexists(folder / "video.toml"):
        raise Refusal(f"{folder}/video.toml is there already; choose another folder with -o or "
                      "remove it")
    link, pictures = folder / "frames", location.parent.resolve()
    if (os.path.lexists(link) and link.resolve() != pictures
            and not pictures.is_relative_to(folder.resolve())):
        raise Refusal(f"{link} is there already and is not {pictures}; choose another folder with "
                      "-o")


def make_folder(folder: Path, location: Path) -> str:
    """Makes the recording reachable from the folder, by a link `frames` unless it is in the folder.
    Returns its location relative to the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = location.parent.resolve()
    if pictures.is_relative_to(folder.resolve()):
        return str(pictures.relative_to(folder.resolve()) / location.name)
    link = folder / "frames"
    if not os.path.lexists(link):
        link.symlink_to(pictures, target_is_directory=True)
    return str(Path("frames") / location.name)


def survey(program: str, location: Path) -> dict:
    done = subprocess.run([program, "survey", str(location)], text=True, capture_output=True,
                          check=False)
    if done.returncode != 0:
        raise Refusal(done.stderr.strip().removeprefix("culm: ")
                      or f"{program} ended with {done.returncode}")
    return json.loads(done.stdout)


def page_text(data: dict) -> str:
    parts = {"style": "page.css", "picture": "picture.js", "script": "page.js"}
    text = (PAGE / "page.html").read_text("utf-8")
    for marker, name in parts.items():
        text = text.replace(f"<!-- {marker} -->", (PAGE / name).read_text("utf-8"))
    data = {**data, "assumed": [f"{what} ({key})" for what, key in assumptions_of(data)]}
    # A name with "</script>" must not end the element.
    return text.replace("<!-- data -->",
                        json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"))


def set_up(arguments):
    location, folder = recording_location(arguments.video), arguments.output
    require_free(folder, location)
    found = survey(arguments.culm_track, location)
    command = shlex.join(["culm", "track", str(folder / "video.toml"), "-o",
                          str(folder / "measurement")])
    data = {"program": arguments.program.split(" (")[0], "folder": str(folder),
            "video": "/".join(location.parts[-2:]), "frames_key": make_folder(folder, location),
            "command": command, **found}
    print(survey_text(data), end="", flush=True)
    if arguments.text:
        write_whole(folder / "video.toml", ask_for_settings(data))
        print(f"written  {folder}/video.toml\n\nnext: {command}")
        return
    page = folder / "setup.html"
    write_whole(page, page_text(data))
    print(f"written  {page}\n\nnext: open {page} in a browser, save video.toml in {folder}, then\n"
          f"      {command}")


def main(arguments=None) -> int:
    try:
        set_up(parse(arguments))
    except (Refusal, OSError) as error:
        print(f"culm: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except EOFError as error:
        print(f"culm: the answers end at {error}; nothing was written", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
