"""The live plots. Their arrays are sent whole, so they hold no more points than the panel has pixels."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
import viser.uplot as up

from dashboard.history import History
from dashboard.layers import DISTANCE_LIMIT
from dashboard.links import LOST_SECONDS
from dashboard.summary import TRACKING_LIMIT
from dashboard.words import plot_title

SKY, VIOLET, PINK, CYAN, MEAN = "#56b4e9", "#b284ff", "#ff79c6", "#40d6d6", "#8b94a5"
NEAR_LIMIT = 0.4
"""The limit line is drawn once the values come near it; before, it would only flatten them."""


@dataclass(frozen=True, slots=True)
class Plot:
    """What one plot shows."""

    name: str
    unit: str
    columns: tuple[tuple[str, str, str], ...]
    """Column of the history, what it is, colour."""
    floor: float
    """The axis reaches at least so far: noise at the micrometre is not news."""
    limit: float | None = None
    cap: float = float("inf")
    """Larger values are shown as this one."""


FIRST = (
    Plot(
        "Pattern distance error",
        "mm",
        (("distance_max", "max", SKY), ("distance_mean", "mean", MEAN)),
        floor=0.1,
        limit=1e3 * DISTANCE_LIMIT,
    ),
    Plot(
        "Age of the newest plan",
        "ms, up to 3 s",
        (("age_max", "max", CYAN), ("age_mean", "mean", MEAN)),
        floor=100.0,
        limit=1e3 * LOST_SECONDS,
        cap=3000.0,
    ),
)
SECOND = (
    Plot("Pattern angle error", "deg", (("angle", "max", VIOLET),), floor=0.1),
    Plot(
        "Tracking error",
        "mm",
        (("tracking", "centre to path", PINK),),
        floor=0.1,
        limit=1e3 * TRACKING_LIMIT,
    ),
)


class Plots:
    """A column of plots in the current tab."""

    def __init__(self, gui: viser.GuiApi, plots: tuple[Plot, ...]) -> None:
        self._plots = plots
        self._handles = [self._add(gui, plot) for plot in plots]

    def _add(self, gui: viser.GuiApi, plot: Plot) -> Any:
        gui.add_html(plot_title(plot.name, plot.unit, tuple((colour, text) for _, text, colour in plot.columns)))
        lines = [
            up.Series(label=text, stroke=colour, width=1.6, points={"show": False}) for _, text, colour in plot.columns
        ]
        thin: Any = {"show": False}
        lines.append(up.Series(label="limit", stroke="rgba(240,72,92,.55)", dash=(5.0, 5.0), width=1, points=thin))
        lines.append(up.Series(label="floor", stroke="transparent", width=1, points=thin))
        lines.append(up.Series(label="event", stroke="rgba(247,184,62,.5)", width=1, points=thin))
        axis = up.Axis(
            size=24,
            font="11px sans-serif",
            stroke="#8b94a5",
            ticks={"show": False},
            grid={"stroke": "rgba(128,140,160,.12)", "width": 1},
        )
        upright = up.Axis(**{**axis, "size": 46})
        return gui.add_uplot(
            tuple(np.zeros(2) for _ in range(len(lines) + 1)),
            (up.Series(label="t"), *lines),
            height=100,
            scales={"x": up.Scale(time=False, auto=True), "y": up.Scale(range=(0, None))},
            axes=(axis, upright),
            legend=up.Legend(show=False),
            cursor=up.Cursor(show=False),
            padding=(8, 10, 0, 0),
        )

    def draw(self, history: History) -> None:
        """Show what was."""
        series = history.series()
        for plot, handle in zip(self._plots, self._handles, strict=True):
            values = [np.minimum(series[column], plot.cap) for column, _, _ in plot.columns]
            top = max(float(value.max()) for value in values)
            near = plot.limit is not None and top > NEAR_LIMIT * plot.limit
            top = max(top, plot.floor)
            hidden = -top  # below the plot
            limit = np.full_like(values[0], plot.limit if near and plot.limit is not None else hidden)
            events = np.where(series["event"] > 0.0, max(top, float(limit[0])), hidden)
            handle.data = (series["t"], *values, limit, np.full_like(limit, plot.floor), events)
