# SPDX-License-Identifier: BSD-3-Clause
"""The tracked motion of a recording as in Fig. 3a of Schramm et al. (2019)."""
from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from figure_style import colour_bar, new_figure, styled
from palette import COLOUR_MAP, GREY, VERMILLION, number
from track_results import TrackResults


@styled
def displacements_figure(track: TrackResults):
    """Fig. 3a: deflection against time at every height, all frames that culm track kept, those in
    which the stem was held included; a line marks the release."""
    release = track.content["release"]
    figure = new_figure(2.8, f"{track.stem}: {number(track.content['fps'])} frames/s, pulled by "
                             f"{number(release['pull_mm'], 3)} mm at "
                             f"{number(release['pull_at_height_mm'])} mm")
    axes = figure.subplots()
    colours = colormaps[COLOUR_MAP]
    heights = track.heights_mm
    scale = Normalize(0.0, max(heights))
    for row, height in enumerate(heights):
        axes.plot(1e3 * track.time_s, track.deflection_mm[:, row], color=colours(scale(height)),
                  linewidth=0.8)
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0)
    axes.axvline(0.0, color=VERMILLION, linewidth=0.8, linestyle="--", label="release")
    axes.set(xlabel="time, ms", ylabel="deflection, mm",
             xlim=(1e3 * np.min(track.time_s), 1e3 * np.max(track.time_s)))
    axes.legend(loc="upper right")
    colour_bar(figure, ScalarMappable(scale, colours), axes, "height above the clamp, mm", heights)
    return figure


FIGURES = {"displacements": displacements_figure}
