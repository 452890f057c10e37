"""The drawings of the report; each is made inside `style.styled()` and saved by `style.save`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from experiments.metrics import Spread
from experiments.report.style import BLACK, GREY, MARKERS, PALETTE, colour, figure
from experiments.trials.result import Signals

EVERY = 10
"""Ticks between two points of a drawn line: 0.1 s, finer than print shows."""
FLOOR = 1e-4
"""Where logarithmic axes of millimetres over time end: a tenth of a micrometre."""
BOX_FLOOR = 1e-6
"""Where those of box plots end: a nanometre, or a nanoradian by the same factor below a millimetre [mm]."""
MILLI = 1e3


@dataclass(frozen=True, slots=True)
class Curve:
    """A line of a plot over time."""

    label: str
    times: np.ndarray
    values: np.ndarray
    colour: str
    style: str = "-"


def over_time(
    panels: Sequence[tuple[str, str, Sequence[Curve]]],
    columns: int,
    *,
    log: Sequence[int] = (),
    height: float = 2.1,
    share: bool = False,
) -> Figure:
    """Lines over time, panel by panel, with one legend for all.

    Args:
        panels: title, label of the y axis, lines; row by row.
        columns: panels in a row.
        log: which panels have a logarithmic y axis.
        height: of a row [inch].
        share: whether the panels of a row have the same y axis.
    """
    rows = -(-len(panels) // columns)
    drawn = figure(height * rows + 0.6)
    grid = drawn.subplots(rows, columns, sharex=True, sharey="row" if share else False, squeeze=False)
    named: dict[str, Artist] = {}
    for place, (axes, (title, label, lines)) in enumerate(zip(grid.flat, panels, strict=True)):
        for line in lines:
            (artist,) = axes.plot(line.times, line.values, line.style, color=line.colour, label=line.label)
            named.setdefault(line.label, artist)
        axes.set_title(title)
        if not share or place % columns == 0:
            axes.set_ylabel(label)
        if place // columns == rows - 1:
            axes.set_xlabel("time t [s]")
        axes.margins(x=0.01)
        if place in log:
            axes.set_yscale("log")
    drawn.legend(
        list(named.values()), list(named), loc="outside upper right", ncols=len(named) if len(named) <= 5 else 4
    )
    return drawn


def trajectories(
    panels: Sequence[tuple[str, Signals]],
    every: float,
    follower: Signals | None = None,
    *,
    zoom: tuple[float, float, float, float] | None = None,
    height: float = 4.0,
) -> Figure:
    """Where the robots and the formation's centre went, as figs. 3, 8 and 10 show it.

    Args:
        panels: title and signals.
        every: a marker stands at every so many seconds.
        follower: a trial of leader-follower, whose follower is drawn as a dashed line (fig. 3).
        zoom: least and greatest x, least and greatest y of a second panel for each trial [m].
        height: [inch].
    """
    drawn = figure(height)
    views = [(title, trial, part) for title, trial in panels for part in ([None, zoom] if zoom else [None])]
    grid = drawn.subplots(1, len(views), sharex=not zoom, sharey=not zoom, squeeze=False)
    for axes, (title, trial, part) in zip(grid.flat, views, strict=True):
        axes.plot(*trial.centre[::EVERY].T, color=GREY, linewidth=3.5, alpha=0.35, label="reference path")
        rows = np.searchsorted(trial.times, np.arange(0.0, trial.times[-1] + 1e-9, every) - 1e-9)
        for robot in range(trial.poses.shape[1]):
            _track(axes, trial.poses[:, robot, :2], rows, f"robot {robot + 1}", PALETTE[robot], MARKERS[robot])
        middle = trial.poses[..., :2].mean(axis=1)
        axes.plot(*middle[rows].T, ".", color=BLACK, markersize=3.5, label="formation centre")
        if follower is not None:
            path = follower.poses[::EVERY, -1, :2]
            axes.plot(*path.T, "--", color=colour("leader_follower"), linewidth=1.0, label="leader-follower's follower")
        axes.set_title(title if part is None else "the corner")
        if part is not None:
            axes.set_xlim(part[:2])
            axes.set_ylim(part[2:])
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlabel("x [m]")
    grid[0, 0].set_ylabel("y [m]")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper right", ncols=6)
    return drawn


def _track(axes: Axes, path: np.ndarray, rows: np.ndarray, label: str, ink: str, marker: str) -> None:
    axes.plot(*path[::EVERY].T, color=ink, linewidth=0.9)
    axes.plot(*path[rows].T, marker, color=ink, markersize=4, markerfacecolor="none", label=label)


def boxes(spreads: Mapping[str, Mapping[str, tuple[Spread, Spread]]], label: str, floor: float) -> Figure:
    """Box-and-whisker plots as figs. 6 and 7 show them: boxes are quartiles, whiskers the range.

    Above signed on a linear axis, as printed; below the absolute value on a logarithmic one, where small boxes can
    be told apart.

    Args:
        spreads: of the signed and of the absolute error, by path and by controller.
        label: of the y axis, with its unit.
        floor: where the logarithmic axis ends.
    """
    drawn = figure(4.9)
    grid = drawn.subplots(2, len(spreads), sharey="row", squeeze=False)
    for column, (path, found) in enumerate(spreads.items()):
        for row in (0, 1):
            axes = grid[row, column]
            for place, (name, pair) in enumerate(found.items()):
                _box(axes, place, pair[row], colour(name, list(found)), floor if row else None)
            axes.set_xticks(range(len(found)), [])
            axes.grid(visible=False, axis="x")
        grid[0, column].set_title(path)
    top = max(pair[1].maximum for found in spreads.values() for pair in found.values())
    grid[1, 0].set_yscale("log")  # of all: they share their y axes
    grid[1, 0].set_ylim(floor, max(2.0 * top, 10.0 * floor))
    symbol, unit = label.split(" ", maxsplit=1)
    grid[0, 0].set_ylabel(label)
    grid[1, 0].set_ylabel(f"|{symbol}| {unit}")
    names = list(next(iter(spreads.values())))
    patches = [Patch(facecolor=colour(n, names) + "44", edgecolor=colour(n, names), label=n) for n in names]
    drawn.legend(handles=patches, loc="outside upper right", ncols=6)
    return drawn


def _box(axes: Axes, place: int, found: Spread, ink: str, floor: float | None) -> None:
    low, q1, median, q3, high = (
        value if floor is None else max(value, floor)
        for value in (found.minimum, found.lower, found.median, found.upper, found.maximum)
    )
    box = {"whislo": low, "q1": q1, "med": median, "q3": q3, "whishi": high}
    style = {"color": ink, "linewidth": 1.1}
    axes.bxp(
        [box],
        positions=[place],
        widths=0.62,
        showfliers=False,
        patch_artist=True,
        boxprops={"facecolor": ink + "44", "edgecolor": ink, "linewidth": 1.1},
        medianprops={**style, "linewidth": 2.0},
        whiskerprops=style,
        capprops=style,
        manage_ticks=False,
    )


def bands(panels: Sequence[tuple[str, str, Sequence[tuple[str, str, np.ndarray, np.ndarray]]]], ylabel: str) -> Figure:
    """Mean over seeds, and the range of the seeds as a band.

    Args:
        panels: title, label of the x axis, and lines: label, colour, x (X,), values (X, seeds).
        ylabel: with its unit.
    """
    drawn = figure(2.9)
    grid = drawn.subplots(1, len(panels), sharey=True, squeeze=False)
    for axes, (title, xlabel, lines) in zip(grid.flat, panels, strict=True):
        for place, (label, ink, x, values) in enumerate(lines):
            axes.plot(x, values.mean(axis=1), color=ink, marker=MARKERS[place], markersize=4, label=label)
            axes.fill_between(x, values.min(axis=1), values.max(axis=1), color=ink, alpha=0.18, linewidth=0)
        axes.set_title(title)
        axes.set_xlabel(xlabel)
    grid[0, 0].set_ylabel(ylabel)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper right", ncols=4)
    return drawn


def error_lines(trial: Signals, *, size: bool = False) -> list[Curve]:
    """l_e of every robot [mm], as figs. 9 and 11 show it; `size` for the absolute value, cut off below."""
    values = trial.distance[::EVERY] * MILLI
    if size:
        values = np.maximum(np.abs(values), FLOOR)
    styles = ("-", "--", "-.", ":")
    return [
        Curve(f"robot {i + 1} to {(i - 1) % values.shape[1] + 1}", trial.times[::EVERY], row, PALETTE[i], styles[i % 4])
        for i, row in enumerate(values.T)
    ]
