#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Renders a high-speed video of a simulated stem: render_video.py DIR [--point N] -o OUT.

DIR is the folder of a study with `store = "full"`, or a folder with stem.toml and axis.csv: the
positions of the stem's axis in each frame, as in tests/data/demo-beam. Writes OUT/frames/00000.pgm …
and OUT/video.toml, ready for `culm track`: a bright stem before uneven light, with blur and noise.
The stem is held for some frames and released between two of them. Prints the path of video.toml.
Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

if __name__ == "__main__":
    from needed_packages import require
    require("numpy", "h5py")

import argparse
import sys
import tomllib
from pathlib import Path

import numpy as np

from culm.archive import Study, StudyError

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
"""
# A simulated chain ends with a whole sphere where a stem ends with half a bond.
TIP_MASS = """
[[added_mass]]
height_mm = {length:g}
mass_g = {tip_mass:.6g}
"""


class Scene:
    """The size of the picture, and the stem in it: heights and deflections (N) in pixels."""

    def __init__(self, positions: np.ndarray, scale: float):
        """`positions` (S, N, 2) in m: axial, lateral; `scale` in mm per pixel."""
        pixels = 1e3 * positions / scale
        self.clamp_row = int(np.ceil(pixels[:, :, 0].max())) + MARGIN_PX
        self.axis_column = int(np.ceil(np.abs(pixels[:, :, 1]).max())) + 2 * MARGIN_PX
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


def frames_of_study(study: Study, options) -> np.ndarray:
    """Positions (F, N, 2) of the axis in each frame, between the samples on straight lines; the stem
    is held before t = 0."""
    positions, times = study.positions(options.point)[:, :, :2], study.time
    count = int(RELEASE_FRAME + options.fps * times[-1])
    place = np.interp((np.arange(count) - RELEASE_FRAME) / options.fps, times, np.arange(times.size))
    before = np.minimum(place.astype(int), times.size - 2)
    share = (place - before)[:, None, None]
    return (1.0 - share) * positions[before] + share * positions[before + 1]


def stem_of_study(study: Study, point: int) -> dict[str, float]:
    """The stem that the chain represents: lengths in mm, the density of touching spheres of the
    stem's diameter with the chain's mass per length, the mass of half a sphere in g."""
    bond, sphere, diameter, density = (
        float(study.parameter(key)[point]) for key in
        ("bond_length_mm", "sphere_diameter_mm", "bond_diameter_mm", "density_kg_m3"))
    return {"length": bond * (study.spheres - 1), "diameter": diameter,
            "density": density * sphere**3 / (diameter**2 * bond),
            "tip_mass": 0.5e-6 * density * np.pi / 6.0 * sphere**3}


def read_axis(folder: Path) -> tuple[dict[str, float], np.ndarray, float]:
    """Stem, positions (F, N, 2) in m and frames per second of stem.toml and axis.csv."""
    stem = tomllib.loads((folder / "stem.toml").read_text(encoding="utf-8"))["stem"]
    table = np.loadtxt(folder / "axis.csv", delimiter=",", skiprows=1)
    positions = 1e-3 * table[:, 1:].reshape(table.shape[0], -1, 2)
    return ({"length": stem["length_mm"], "diameter": stem["diameter_mm"],
             "density": stem["density_kg_m3"]}, positions,
            float((table.shape[0] - 1) / (table[-1, 0] - table[0, 0])))


def render(stem: dict[str, float], positions: np.ndarray, fps: float, options) -> Path:
    """Writes the frames and video.toml; returns the latter's path."""
    scene = Scene(positions, options.mm_per_px)
    frames = options.output / "frames"
    frames.mkdir(parents=True, exist_ok=True)
    for number, moment in enumerate(positions):
        pixels = 1e3 * moment / options.mm_per_px
        noise = np.random.Generator(np.random.Philox(key=number))
        picture = scene.picture(pixels[:, 0], pixels[:, 1], stem["diameter"] / options.mm_per_px,
                                noise)
        header = b"P5 %d %d 255\n" % (scene.columns, scene.rows)
        (frames / f"{number:05d}.pgm").write_bytes(header + picture.tobytes())
    settings = options.output / "video.toml"
    text = SETTINGS + (TIP_MASS if "tip_mass" in stem else "")
    settings.write_text(text.format(
        fps=fps, scale=options.mm_per_px, clamp_row=scene.clamp_row,
        axis_column=scene.axis_column, name=options.name, **stem), encoding="utf-8")
    return settings


def parse(arguments):
    parser = argparse.ArgumentParser(prog="render_video.py",
                                     description="A video of a simulated stem, for culm track.")
    parser.add_argument("directory", metavar="DIR", type=Path,
                        help="folder of a study with store = \"full\", or with stem.toml and axis.csv")
    parser.add_argument("-o", "--output", metavar="OUT", type=Path, required=True,
                        help="folder for the frames and video.toml")
    parser.add_argument("--point", metavar="N", type=int, default=0, help="which point (0)")
    parser.add_argument("--fps", metavar="F", type=float, default=960.0,
                        help="frames per second of a study (960)")
    parser.add_argument("--mm-per-px", metavar="L", type=float, default=0.5,
                        help="scale of the picture (0.5)")
    parser.add_argument("--name", metavar="ID", default="V1", help="id of the stem (V1)")
    return parser.parse_args(arguments)


def main(arguments=None) -> int:
    options = parse(arguments)
    try:
        if (options.directory / "axis.csv").is_file():
            print(render(*read_axis(options.directory), options))
        else:
            with Study(options.directory) as study:
                print(render(stem_of_study(study, options.point),
                             frames_of_study(study, options), options.fps, options))
    except (StudyError, ValueError, KeyError) as error:
        print(f"render_video.py: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"render_video.py: {error.filename}: {error.strerror}.", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
