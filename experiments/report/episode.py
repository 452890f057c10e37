"""A figure of one episode: the ways of the robots, and the pattern errors over time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.report import style
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

DRAWN = 3000
"""Points of a line, at most."""
SMALLEST = 1e-4
"""Errors below this are drawn as this [mm]."""


def draw(
    scenario: Scenario,
    times: FloatArray,
    poses: FloatArray,
    centre: FloatArray,
    distance: FloatArray,
    angle: FloatArray,
    excursions: Sequence[Mapping[str, Any]] = (),
) -> Figure:
    """The figure.

    Args:
        scenario: of the episode.
        times: (T + 1,) [s].
        poses: (T + 1, n, 3) [m, m, rad].
        centre: (T + 1, 2) where the formation's centre should be [m].
        distance: (T + 1, n) l_e [m]; NaN is not drawn.
        angle: (T + 1, n) psi_e [rad]; NaN likewise.
        excursions: of the summary; each is shaded in the plot of the distance error, in its robot's colour.
    """
    rows = slice(None, None, max(1, len(times) // DRAWN))
    with style.styled():
        figure = style.figure(3.2)
        ways, errors, angles = figure.subplots(1, 3)
        ways.plot(*centre[rows].T, color=style.GREY, linewidth=0.8, linestyle=":")
        for i in range(scenario.size):
            colour = style.PALETTE[i % len(style.PALETTE)]
            ways.plot(*poses[rows, i, :2].T, color=colour, linewidth=0.9, label=f"robot {i + 1}")
            ways.plot(*poses[-1, i, :2], color=colour, marker="o", markersize=4)
            errors.plot(times[rows], np.maximum(np.abs(distance[rows, i]) * 1e3, SMALLEST), color=colour)
            angles.plot(times[rows], np.maximum(np.abs(angle[rows, i]), SMALLEST * 1e-3), color=colour)
        for one in excursions:
            ends = times[-1] if one["until"] is None else one["until"]
            colour = style.PALETTE[(int(one["robot"]) - 1) % len(style.PALETTE)]
            errors.axvspan(one["t"], ends, color=colour, alpha=0.2)
        ways.set(title="Ways", xlabel="x [m]", ylabel="y [m]", aspect="equal")
        errors.set(title="Distance error", xlabel="t [s]", ylabel="|l_e| [mm]", yscale="log")
        angles.set(title="Angle error", xlabel="t [s]", ylabel="|psi_e| [rad]", yscale="log")
        if scenario.size <= len(style.PALETTE):
            ways.legend(loc="best", fontsize=6)
        figure.draw_without_rendering()
    return figure
