# SPDX-License-Identifier: BSD-3-Clause
"""A recording that is neither simulated nor rendered by culm: a dark cantilever in front of a bright,
unevenly lit background, clamped at the right of the picture.

The motion is the free vibration of an Euler-Bernoulli beam after a force at its tip is removed, summed
over four modes. The pictures are PGM files of a few columns of arithmetic.
"""
from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 480, 240
CLAMP_COLUMN, TIP_COLUMN, AXIS_ROW = 440.0, 40.0, 118.0
THICKNESS = 7.0  # pixels
MM_PER_PX = 0.4
LENGTH_MM, DIAMETER_MM = 160.0, 2.8
FPS, FRAMES, HELD = 960.0, 160, 12  # the stem is let go half a frame after the last held one
FREQUENCY, DAMPING_RATIO = 80.0, 0.02  # of the first mode, Hz
PULL = 45.0  # pixels at the tip, downward in the picture
ROOTS = np.array([1.875104, 4.694091, 7.854757, 10.995541])


def modes(s):
    """Shapes (modes, places) of a clamped-free beam at the relative heights s."""
    x = ROOTS[:, None] * s
    ratio = (np.cosh(ROOTS) + np.cos(ROOTS)) / (np.sinh(ROOTS) + np.sin(ROOTS))
    return np.cosh(x) - np.cos(x) - ratio[:, None] * (np.sinh(x) - np.sin(x))


def deflection(s, time):
    """At relative heights s, pixels; `time` after the release, s."""
    grid = np.linspace(0.0, 1.0, 2001)
    shapes = modes(grid)
    static = grid ** 2 * (3.0 - grid) / 2.0
    shares = (shapes * static).sum(axis=1) / (shapes ** 2).sum(axis=1)
    omega = 2.0 * np.pi * FREQUENCY * (ROOTS / ROOTS[0]) ** 2
    if time <= 0.0:
        motion = np.ones(len(ROOTS))
    else:
        motion = np.exp(-DAMPING_RATIO * omega * time) * np.cos(omega * time)
    return PULL * (shares * motion) @ modes(s)


def picture(time, noise):
    """Grey values (HEIGHT, WIDTH)."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    light = 120.0 + 0.2 * columns + 30.0 * np.sin(rows / 60.0)
    s = np.clip((CLAMP_COLUMN - np.arange(WIDTH)) / (CLAMP_COLUMN - TIP_COLUMN), 0.0, 1.0)
    distance = np.abs(rows - AXIS_ROW - deflection(s, time)[None, :])
    cover = np.clip(0.5 * THICKNESS + 0.5 - distance, 0.0, 1.0)
    cover *= np.clip(columns - TIP_COLUMN + 0.5, 0.0, 1.0) * (columns < CLAMP_COLUMN)
    grey = light * (1.0 - 0.7 * cover)
    grey[60:180, int(CLAMP_COLUMN):] = 50.0
    return np.clip(np.rint(grey + noise.normal(0.0, 2.5, grey.shape)), 0, 255).astype(np.uint8)


def write_frames(folder: Path):
    """frame_0000.pgm, frame_0001.pgm, …"""
    folder.mkdir(parents=True)
    noise = np.random.default_rng(7)
    for number in range(FRAMES):
        grey = picture((number - HELD + 0.5) / FPS, noise)
        (folder / f"frame_{number:04}.pgm").write_bytes(
            b"P5 %d %d 255\n" % (WIDTH, HEIGHT) + grey.tobytes())
