"""The live plots: a description of each, and the chart that draws it.

viser sends a plot's arrays whole each time, so they hold no more points than the panel has pixels.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
import viser.uplot as up

from dashboard.panels.mirrored_controls import set_if_changed
from dashboard.telemetry.ghost_track import FAR_BEHIND
from dashboard.telemetry.links import LOST_SECONDS
from dashboard.theme.limits import DISTANCE_LIMIT, TRACKING_LIMIT
from dashboard.theme.palette import DARK, LIGHT, Palette
from dashboard.theme.templates import render
from formation.arrays import FloatArray

SKY, VIOLET, PINK, CYAN, BLUE, MEAN, GHOST = "r1", "r2", "r3", "r4", "r6", "muted", "ghost"
"""Names of colours in the palettes."""
LIMIT, EVENT, INVISIBLE = "rgba(240,72,92,.55)", "rgba(247,184,62,.5)", "transparent"
SPAN, CHOSEN = "rgba(247,184,62,.13)", "rgba(86,180,233,.28)"
"""Behind the curves while a fault or a push acts, and during the excursion that is chosen in the ledger."""
Span = tuple[float, float]
"""Begin and end [s]."""
NEAR_LIMIT = 0.4
"""The limit is drawn once values reach this share of it; before, it would only flatten the curves."""
HEIGHT = 84
"""Of a plot [px]."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve of a plot."""

    column: str
    """Column of the history."""
    text: str
    colour: str
    """A name in the palettes, or a CSS colour."""
    dash: tuple[float, float] | None = None
    fill: str | None = None
    """What is below it is filled with this CSS colour."""

    @property
    def ghost(self) -> bool:
        """Whether it is the ghost's, and shown only while there is one."""
        return self.column.startswith("ghost")


@dataclass(frozen=True, slots=True)
class Plot:
    """Description of one plot."""

    name: str
    unit: str
    curves: tuple[Curve, ...]
    floor: float
    """The axis reaches at least so far, so that noise of a micrometre does not fill it."""
    limit: float | None = None
    cap: float = float("inf")
    """Larger values are drawn as this one."""


def _ghost(column: str) -> Curve:
    return Curve(column, "ghost", GHOST, (4.0, 3.0))


FIRST = (
    Plot(
        "Pattern distance error",
        "mm",
        (Curve("distance_max", "max", SKY), Curve("distance_mean", "mean", MEAN), _ghost("ghost_distance")),
        floor=0.1,
        limit=1e3 * DISTANCE_LIMIT,
    ),
    Plot(
        "Age of newest plan",
        "ms",
        (Curve("age_max", "max", CYAN), Curve("age_mean", "mean", MEAN)),
        floor=100.0,
        limit=1e3 * LOST_SECONDS,
        cap=3000.0,
    ),
)
SECOND = (
    Plot("Pattern angle error", "deg", (Curve("angle", "max", VIOLET), _ghost("ghost_angle")), floor=0.1),
    Plot(
        "Tracking error",
        "mm",
        (Curve("tracking", "centre to path", PINK), _ghost("ghost_tracking")),
        floor=0.1,
        limit=1e3 * TRACKING_LIMIT,
    ),
    Plot("Solve time", "ms per plan", (Curve("solve_max", "max", BLUE), Curve("solve_mean", "mean", MEAN)), floor=0.1),
)

BELIEF = Plot(
    "Belief to truth",
    "mm",
    (Curve("off_max", "max", SKY), Curve("off_mean", "mean", MEAN)),
    floor=1.0,
    limit=1e3 * DISTANCE_LIMIT,
)

_AXIS = up.Axis(
    size=24,
    font="11px sans-serif",
    stroke="#8b94a5",
    ticks={"show": False},
    grid={"stroke": "rgba(128,140,160,.12)", "width": 1},
)


class Chart:
    """One plot on the page."""

    def __init__(self, gui: viser.GuiApi, plot: Plot) -> None:
        """In the current tab."""
        self._plot = plot
        self._title: Any = gui.add_html("")
        # Behind the plot's own curves: its limit, the least top of its axis, spikes at events and at the cursor.
        extra = (
            Curve("", "limit", LIMIT, (5.0, 5.0)),
            Curve("", "floor", INVISIBLE),
            Curve("", "event", EVENT),
            Curve("", "cursor", "ink"),
        )
        # The first are drawn first.
        shades = (Curve("", "acts", INVISIBLE, fill=SPAN), Curve("", "chosen", INVISIBLE, fill=CHOSEN))
        curves = (*shades, *plot.curves, *extra)
        # One plot for each theme, of which one is shown: a plot that changes its colours would lose its time axis.
        self._handles = {palette: self._add(gui, curves, palette) for palette in (DARK, LIGHT)}
        self._handle = self._handles[DARK]

    def _add(self, gui: viser.GuiApi, curves: tuple[Curve, ...], palette: Palette) -> Any:
        return gui.add_uplot(
            tuple(np.zeros(2) for _ in range(len(curves) + 1)),
            _series(curves, palette),
            visible=palette is DARK,
            height=HEIGHT,
            scales={"x": up.Scale(time=False, auto=True), "y": up.Scale(range=(0, None))},
            axes=(_AXIS, up.Axis(**{**_AXIS, "size": 46})),
            legend=up.Legend(show=False),
            cursor=up.Cursor(show=False),
            padding=(8, 10, 0, 0),
        )

    def set_palette(self, palette: Palette) -> None:
        """Draw in another theme from now on."""
        shown, self._handle = self._handle, self._handles[palette]
        if self._handle is not shown:
            self._handle.data = shown.data
            shown.visible, self._handle.visible = False, True

    def draw(
        self,
        series: dict[str, FloatArray],
        *,
        ghost: bool,
        cursor: float | None = None,
        spans: Sequence[Span] = (),
        chosen: Span | None = None,
    ) -> None:
        """Show the columns of the history.

        Args:
            series: columns by name.
            ghost: whether there is a ghost.
            cursor: the moment that is looked at, if it is not the newest [s].
            spans: when faults and pushes acted [s].
            chosen: the excursion that is chosen [s].
        """
        plot = self._plot
        shown = [curve for curve in plot.curves if ghost or not curve.ghost]
        set_if_changed(self._title, "content", render("panels/plot_title.html", plot=plot, curves=shown))
        values = [np.minimum(_held(series["t"], series[curve.column]), plot.cap) for curve in plot.curves]
        top = max(np.nanmax(value, initial=plot.floor) for value in values)
        near = plot.limit is not None and top > NEAR_LIMIT * plot.limit
        hidden = -top  # below the plot, because uPlot draws no gaps
        limit = plot.limit if near and plot.limit is not None else hidden
        values = [np.nan_to_num(value, nan=hidden) for value in values]
        flat = [np.full_like(values[0], level) for level in (limit, plot.floor)]
        event = np.where(series["event"] > 0.0, max(top, limit), hidden)
        here = np.full_like(event, hidden)
        if cursor is not None:
            here[np.abs(series["t"] - cursor).argmin()] = max(top, limit)
        shades = [_during(series["t"], some, max(top, limit), hidden) for some in (spans, [chosen] if chosen else [])]
        self._handle.data = (series["t"], *shades, *values, *flat, event, here)


def _during(stamps: FloatArray, spans: Sequence[Span], inside: float, outside: float) -> FloatArray:
    """One value during the spans, the other else."""
    found = np.full_like(stamps, outside)
    for begins, ends in spans:
        found[np.searchsorted(stamps, begins) : np.searchsorted(stamps, ends, side="right")] = inside
    return found


def _series(curves: tuple[Curve, ...], palette: Palette) -> tuple[up.Series, ...]:
    """uPlot's series of the time and of these curves."""
    named, found = palette.named(), [up.Series(label="t")]
    for curve in curves:
        colour = f"#{named[curve.colour]}" if curve.colour in named else curve.colour
        width = 1.6 if curve.column else 1.0
        series = up.Series(label=curve.text, stroke=colour, width=width, points={"show": False})
        if curve.dash is not None:
            series["dash"] = curve.dash
        if curve.fill is not None:
            series["fill"] = curve.fill
        found.append(series)
    return tuple(found)


def _held(stamps: FloatArray, values: FloatArray) -> FloatArray:
    """The values, held at both ends while a ghost's message may be on its way, so that its curve has no step."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) in (0, len(values)):
        return values
    first, last = known[0], known[-1]
    near = (stamps >= stamps[first] - FAR_BEHIND) & (stamps <= stamps[last] + FAR_BEHIND)
    return np.where(near, np.interp(stamps, stamps[known], values[known]), values)
