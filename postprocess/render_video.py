#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Renders a high-speed video of a simulated stem: render_video.py DIR [--point N] -o OUT.

DIR is the folder of a study with `store = "full"`. Writes OUT/frames/00000.pgm … and OUT/video.toml,
ready for `culm track`: a bright stem before uneven light, with blur and noise. The stem is held for
some frames and let go between two of them. Prints the path of video.toml. Exit codes: 0 done, 2 bad
input.
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "h5py")

import argparse
import sys
from pathlib import Path

import numpy as np

from culm_archive import Study, StudyError

EXIT_BAD_INPUT = 2
HELD_FRAMES = 8
RELEASE_FRAME = 7.6  # the stem is let go between frames 7 and 8
MARGIN_PX = 20  # around the stem
BACKGROUND, CONTRAST = 60.0, 110.0  # grey values
EDGE_PX = 0.8  # width of the stem's edges: the blur of the lens
NOISE = 3.0  # grey values

SETTINGS = """[video]
frames = "frames/%05d.pgm"
fps = {fps:g}
mm_per_px = {scale:g}
clamp_row = {clamp_row}
axis_column = {axis_column}
up = "decreasing_row"

[stem]
id = "{name}"
length_mm = {length:g}
diameter_mm = {diameter:g}
density_kg_m3 = {density:.6g}

# A simulated chain ends with a whole sphere where a stem ends with half a bond.
[[added_mass]]
height_mm = {length:g}
mass_g = {tip_mass:.6g}
"""


class Scene:
    """Where the stem's axis is in the picture: heights and deflections (N) in pixels."""

    def __init__(self, positions: np.ndarray, options):
        """`positions` (S, N, 3) in m: axial, lateral, out of plane."""
        self.scale = options.mm_per_px
        pixels = 1e3 * positions[:, :, :2] / self.scale
        self.heights, self.deflections = pixels[:, :, 0], pixels[:, :, 1]
        self.clamp_row = int(np.ceil(self.heights.max())) + MARGIN_PX
        self.axis_column = int(np.ceil(np.abs(self.deflections).max())) + 2 * MARGIN_PX
        self.rows = self.clamp_row + MARGIN_PX
        self.columns = 2 * self.axis_column + 1

    def picture(self, heights, deflections, width_px: float, noise: np.random.Generator):
        """8-bit grey picture (rows, columns) of one moment."""
        row, column = np.arange(self.rows)[:, None], np.arange(self.columns)[None, :]
        above = self.clamp_row - row[:, 0]
        axis = self.axis_column + np.interp(above, heights, deflections)
        # Across the stem, not along the row: a leaning stem is no wider than an upright one.
        slope = np.interp(above, 0.5 * (heights[1:] + heights[:-1]),
                          np.diff(deflections) / np.diff(heights))
        distance = np.abs(column - axis[:, None]) / np.hypot(1.0, slope)[:, None]
        covered = 1.0 / (1.0 + np.exp((distance - 0.5 * width_px) / (0.5 * EDGE_PX)))
        is_stem = (above >= 0) & (above <= heights[-1])
        light = BACKGROUND * (1.0 + 0.2 * column / self.columns + 0.1 * row / self.rows)
        grey = light + CONTRAST * covered * is_stem[:, None]
        grey += NOISE * noise.standard_normal(grey.shape)
        return np.clip(np.round(grey), 0, 255).astype(np.uint8)


def at_time(study: Study, positions: np.ndarray, time: float) -> np.ndarray:
    """Positions (N, 3) at a time, between the samples on a straight line; held before t = 0."""
    times = study.time
    place = float(np.interp(time, times, np.arange(times.size)))
    before = min(int(place), times.size - 2)
    share = place - before
    return (1.0 - share) * positions[before] + share * positions[before + 1]


def stem_of(study: Study, point: int) -> dict[str, float]:
    """The stem that the chain stands for: lengths in mm, the density of touching spheres of the
    stem's diameter with the chain's mass per length, the mass of half a sphere in g."""
    bond, sphere, diameter, density = (
        float(study.parameter(key)[point]) for key in
        ("bond_length_mm", "sphere_diameter_mm", "bond_diameter_mm", "density_kg_m3"))
    return {"length": bond * (study.spheres - 1), "diameter": diameter,
            "density": density * sphere**3 / (diameter**2 * bond),
            "tip_mass": 0.5e-6 * density * np.pi / 6.0 * sphere**3}


def render(study: Study, options) -> Path:
    """Writes the frames and video.toml; returns the latter's path."""
    positions = study.positions(options.point)
    scene = Scene(positions, options)
    frames = options.output / "frames"
    frames.mkdir(parents=True, exist_ok=True)
    stem = stem_of(study, options.point)
    count = int(RELEASE_FRAME + options.fps * study.time[-1])
    for number in range(count):
        moment = at_time(study, positions, (number - RELEASE_FRAME) / options.fps)
        pixels = 1e3 * moment[:, :2] / scene.scale
        noise = np.random.Generator(np.random.Philox(key=number))
        picture = scene.picture(pixels[:, 0], pixels[:, 1], stem["diameter"] / scene.scale, noise)
        header = b"P5 %d %d 255\n" % (scene.columns, scene.rows)
        (frames / f"{number:05d}.pgm").write_bytes(header + picture.tobytes())
    settings = options.output / "video.toml"
    settings.write_text(SETTINGS.format(
        fps=options.fps, scale=scene.scale, clamp_row=scene.clamp_row,
        axis_column=scene.axis_column, name=options.name, **stem), encoding="utf-8")
    return settings


def parse(arguments):
    parser = argparse.ArgumentParser(prog="render_video.py",
                                     description="A video of a simulated stem, for culm track.")
    parser.add_argument("directory", metavar="DIR", type=Path,
                        help="folder of a study with store = \"full\"")
    parser.add_argument("-o", "--output", metavar="OUT", type=Path, required=True,
                        help="folder for the frames and video.toml")
    parser.add_argument("--point", metavar="N", type=int, default=0, help="which point (0)")
    parser.add_argument("--fps", metavar="F", type=float, default=960.0,
                        help="frames per second (960)")
    parser.add_argument("--mm-per-px", metavar="L", type=float, default=0.5,
                        help="scale of the picture (0.5)")
    parser.add_argument("--name", metavar="ID", default="V1", help="id of the stem (V1)")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)
    try:
        with Study(options.directory) as study:
            print(render(study, options))
    except StudyError as error:
        print(f"render_video.py: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"render_video.py: {error.filename}: {error.strerror}.", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
