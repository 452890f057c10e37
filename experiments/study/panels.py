"""The kinds of picture a study has: lines with bands over seeds, surfaces over two axes, recovery after an event."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from experiments.report import style
from experiments.study.flights import SERIES_INTERVAL, Result
from experiments.study.grid import Job
from experiments.study.intervals import Group, Interval, interval
from experiments.study.outcomes import MEASURES
from experiments.study.study import Figure, Study, Value
from formation.arrays import FloatArray

SHOWN = {"m": ("mm", 1e3), "rad": ("rad", 1.0), "s": ("s", 1.0), "1": ("%", 100.0)}
"""SI unit: what a figure shows, and how many of it."""
LEAST = 1e-6
"""What is below counts as this much where logarithms are taken [mm]."""
FLOOR = 10.0
"""A band on a logarithmic axis ends this many times below the least mean."""


def _chosen(wish: Figure, cell: dict[str, Value], **fixed: Value | None) -> bool:
    """Whether a point of the grid is on a line of a panel."""
    return all(cell[axis] in labels for axis, labels in wish.only.items()) and all(
        cell[axis] == label for axis, label in fixed.items() if label is not None
    )


def with_unit(study: Study, axis: str | None, label: Value) -> str:
    """A label of an axis as people read it."""
    unit = next((a.unit for a in study.axes if a.name == axis), "")
    return f"{label:g} {unit}".strip() if isinstance(label, float) else f"{label} {unit}".strip()


def _axis_label(study: Study, axis: str | None) -> str:
    unit = next((a.unit for a in study.axes if a.name == axis), "")
    return f"{axis} [{unit}]" if unit else str(axis)


def value_label(wish: Figure) -> str:
    """What a figure shows, with its unit."""
    measure = MEASURES[str(wish.value)]
    return f"{measure.words}, ratio" if wish.ratio else f"{measure.words} [{SHOWN[measure.unit][0]}]"


def _values(wish: Figure, group: Group) -> FloatArray:
    return group.ratios if wish.ratio else group.values * SHOWN[MEASURES[group.measure].unit][1]


def _look(study: Study, wish: Figure, line: Value | None) -> dict[str, Any]:
    """Colour and marker of a line, the same in every figure of the study."""
    names = [str(label) for label in study.labels[wish.by]] if wish.by else ["None"]
    place = names.index(str(line))
    free = [c for c in style.PALETTE if c not in {style.CONTROLLERS[n] for n in names if n in style.CONTROLLERS}]
    others = [n for n in names if n not in style.CONTROLLERS]
    colour = style.CONTROLLERS.get(str(line)) or free[others.index(str(line)) % len(free)]
    return {"color": colour, "marker": style.MARKERS[place % len(style.MARKERS)]}


def _logarithmic(axes: Axes) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    near = np.log10(axes.get_ylim()[1] / axes.get_ylim()[0]) < 1.2  # then the minor ticks are needed to read it
    axes.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if near else "")


def bands(
    axes: Axes, study: Study, wish: Figure, found: Sequence[Group], panel: Value | None, lines: Sequence[Value | None]
) -> dict[str, Any]:
    """A line over x per label of `by`."""
    labels = study.labels[str(wish.x)]
    numeric = all(isinstance(label, int | float) for label in labels)
    handles: dict[str, Any] = {}
    for line in lines:
        points: list[tuple[float, Interval]] = []
        fixed = {axis: label for axis, label in ((wish.by, line), (wish.panels, panel)) if axis is not None}
        for group in found:
            if group.measure == wish.value and _chosen(wish, group.cell, **fixed):
                over = interval(_values(wish, group))
                label = group.cell[str(wish.x)]
                if over is not None:
                    points.append((float(label) if numeric else float(labels.index(label)), over))
        if not points:
            continue
        x = [at for at, _ in points]
        look = _look(study, wish, line)
        (handle,) = axes.plot(x, [over.mean for _, over in points], markersize=4, **look)
        low, high = [over.low for _, over in points], [over.high for _, over in points]
        least = min(over.mean for _, over in points) / FLOOR if wish.log else -np.inf
        axes.fill_between(x, np.maximum(low, least), high, color=look["color"], alpha=0.2, linewidth=0)
        handles[str(line)] = handle
    if not numeric:
        axes.set_xticks(range(len(labels)), [str(label) for label in labels])
    elif wish.log_x:
        axes.set_xscale("log", base=2)
        axes.set_xticks([float(label) for label in labels], [str(label) for label in labels])
        axes.minorticks_off()
    if wish.log:
        _logarithmic(axes)
    if wish.ratio:
        axes.axhline(1.0, color=style.GREY, linewidth=0.8, zorder=1)
    axes.set_xlabel(_axis_label(study, wish.x))
    axes.set_ylabel(value_label(wish))
    return handles


def surface(axes: Axes, study: Study, wish: Figure, found: Sequence[Group], panel: Value | None) -> Any:
    """The mean over x and y, as a map with its numbers."""
    across, up = study.labels[str(wish.x)], study.labels[str(wish.y)]
    mean = np.full((len(up), len(across)), np.nan)
    shown = [g for g in found if g.measure == wish.value and _chosen(wish, g.cell)]
    everywhere = [float(_values(wish, g).mean()) for g in shown if _values(wish, g).size]
    for group in shown:
        if panel is None or group.cell[str(wish.panels)] == panel:
            values = _values(wish, group)
            if values.size:
                mean[up.index(group.cell[str(wish.y)]), across.index(group.cell[str(wish.x)])] = values.mean()
    norm = "log" if wish.log else "linear"
    image = axes.imshow(mean, origin="lower", aspect="auto", cmap="cividis", norm=norm)
    image.set_clim(min(everywhere), max(everywhere))
    middle = np.sqrt(min(everywhere) * max(everywhere)) if wish.log else (min(everywhere) + max(everywhere)) / 2.0
    for (row, column), value in np.ndenumerate(mean):
        if np.isfinite(value):
            ink = "white" if value < middle else "black"
            axes.text(column, row, f"{value:.3g}", ha="center", va="center", fontsize=7, color=ink)
    axes.set_xticks(range(len(across)), [f"{label}" for label in across])
    axes.set_yticks(range(len(up)), [f"{label}" for label in up])
    axes.grid(visible=False)
    axes.set_xlabel(_axis_label(study, wish.x))
    axes.set_ylabel(_axis_label(study, wish.y))
    return image


def recovery(
    axes: Axes,
    study: Study,
    wish: Figure,
    jobs: Sequence[Job],
    results: Sequence[Result],
    panel: Value | None,
    lines: Sequence[Value | None],
) -> dict[str, Any]:
    """The level over time, mean and interval over seeds, with the event."""
    event = study.event
    assert event is not None  # the study says so
    handles: dict[str, Any] = {}
    for line in lines:
        fixed = {axis: label for axis, label in ((wish.by, line), (wish.panels, panel)) if axis is not None}
        chosen = [r.series for j, r in zip(jobs, results, strict=True) if _chosen(wish, dict(j.cell), **fixed)]
        length = min(len(series) for series in chosen)
        level = 1e3 * np.array([series[:length] for series in chosen])
        t = study.warmup + SERIES_INTERVAL * np.arange(length)
        look = _look(study, wish, line)
        # On a logarithmic axis the mean of the logarithms: its interval does not reach below zero.
        values = np.log(np.maximum(level, LEAST)) if wish.log else level
        over = [interval(values[:, k]) for k in range(length)]
        middle = np.array([(o.mean, o.low, o.high) for o in over if o is not None])
        middle = np.exp(middle) if wish.log else middle
        (handle,) = axes.plot(t, middle[:, 0], color=look["color"], linewidth=1.2)
        axes.fill_between(t, middle[:, 1], middle[:, 2], color=look["color"], alpha=0.2, linewidth=0)
        handles[str(line)] = handle
    axes.axvspan(event.at, event.until, color=style.GREY, alpha=0.15, linewidth=0, zorder=0)
    if event.below is not None:
        axes.axhline(event.below * 1e3, color=style.GREY, linewidth=0.8, linestyle="--", zorder=1)
    if wish.log:
        _logarithmic(axes)
    axes.set_xlabel("t [s]")
    words = f"RMS of $l_e$ over {event.window:g} s" if event.window else "$|l_e|$"
    axes.set_ylabel(f"{words}, worst robot [mm]")
    return handles
