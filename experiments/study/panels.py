"""The kinds of figure a study has: lines with bands over seeds, surfaces over two axes, recovery after an event."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from experiments.report import style
from experiments.study.intervals import Group, Interval, interval
from experiments.study.study import FigureSpec, Study, Value
from experiments.trials.measures import MEASURES
from experiments.trials.result import TrialResult
from experiments.trials.trial import SERIES_INTERVAL, Trial
from formation.arrays import FloatArray

SHOWN = {
    "m": ("mm", 1e3),
    "rad": ("rad", 1.0),
    "s": ("s", 1.0),
    "m/s": ("mm/s", 1e3),
    "1/s": ("1/s", 1.0),
    "B/s": ("kB/s", 1e-3),
    "pairs": ("pairs", 1.0),
    "times": ("times", 1.0),
    "1": ("%", 100.0),
}
"""SI unit: what a figure shows, and how many of it."""
LEAST = 1e-6
"""What is below counts as this much where logarithms are taken [mm]."""
FLOOR = 10.0
"""A band on a logarithmic axis ends this many times below the least mean."""


def _chosen(spec: FigureSpec, cell: Mapping[str, Value], **fixed: Value | None) -> bool:
    """Whether a point of the grid is on a line of a panel."""
    return all(cell[axis] in labels for axis, labels in spec.only.items()) and all(
        cell[axis] == label for axis, label in fixed.items() if label is not None
    )


def with_unit(study: Study, axis: str | None, label: Value) -> str:
    """A label of an axis with its unit."""
    unit = next((a.unit for a in study.axes if a.name == axis), "")
    return f"{label:g} {unit}".strip() if isinstance(label, float) else f"{label} {unit}".strip()


def _axis_label(study: Study, axis: str | None) -> str:
    unit = next((a.unit for a in study.axes if a.name == axis), "")
    return f"{axis} [{unit}]" if unit else str(axis)


def value_label(spec: FigureSpec) -> str:
    """What a figure shows, with its unit."""
    measure = MEASURES[str(spec.value)]
    return f"{measure.label}, ratio" if spec.ratio else f"{measure.label} [{SHOWN[measure.unit][0]}]"


def _values(spec: FigureSpec, group: Group) -> FloatArray:
    return group.ratios if spec.ratio else group.values * SHOWN[MEASURES[group.measure].unit][1]


def _look(study: Study, spec: FigureSpec, line: Value | None) -> dict[str, Any]:
    """Colour and marker of a line, the same in every figure of the study."""
    names = [str(label) for label in study.labels[spec.by]] if spec.by else ["None"]
    place = names.index(str(line))
    known = style.controllers()
    free = [c for c in style.PALETTE if c not in {known[n] for n in names if n in known}]
    others = [n for n in names if n not in known]
    colour = known.get(str(line)) or free[others.index(str(line)) % len(free)]
    return {"color": colour, "marker": style.MARKERS[place % len(style.MARKERS)]}


def _logarithmic(axes: Axes) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    near = np.log10(axes.get_ylim()[1] / axes.get_ylim()[0]) < 1.2  # then the minor ticks are needed to read it
    axes.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if near else "")


def bands(
    axes: Axes,
    study: Study,
    spec: FigureSpec,
    found: Sequence[Group],
    panel: Value | None,
    lines: Sequence[Value | None],
) -> dict[str, Any]:
    """A line over x per label of `by`."""
    labels = study.labels[str(spec.x)]
    numeric = all(isinstance(label, int | float) for label in labels)
    handles: dict[str, Any] = {}
    for line in lines:
        points: list[tuple[float, Interval]] = []
        fixed = {axis: label for axis, label in ((spec.by, line), (spec.panels, panel)) if axis is not None}
        for group in found:
            if group.measure == spec.value and _chosen(spec, group.cell, **fixed):
                over = interval(_values(spec, group))
                label = group.cell[str(spec.x)]
                if over is not None:
                    points.append((float(label) if numeric else float(labels.index(label)), over))
        if not points:
            continue
        x = [at for at, _ in points]
        look = _look(study, spec, line)
        (handle,) = axes.plot(x, [over.mean for _, over in points], markersize=4, **look)
        low, high = [over.low for _, over in points], [over.high for _, over in points]
        least = min(over.mean for _, over in points) / FLOOR if spec.log else -np.inf
        axes.fill_between(x, np.maximum(low, least), high, color=look["color"], alpha=0.2, linewidth=0)
        handles[str(line)] = handle
    if not numeric:
        axes.set_xticks(range(len(labels)), [str(label) for label in labels])
    elif spec.log_x:
        axes.set_xscale("log", base=2)
        axes.set_xticks([float(label) for label in labels], [str(label) for label in labels])
        axes.minorticks_off()
    if spec.log:
        _logarithmic(axes)
    if spec.ratio:
        axes.axhline(1.0, color=style.GREY, linewidth=0.8, zorder=1)
    axes.set_xlabel(_axis_label(study, spec.x))
    axes.set_ylabel(value_label(spec))
    return handles


def surface(axes: Axes, study: Study, spec: FigureSpec, found: Sequence[Group], panel: Value | None) -> Any:
    """The mean over x and y, as a map with its numbers."""
    across, up = study.labels[str(spec.x)], study.labels[str(spec.y)]
    mean = np.full((len(up), len(across)), np.nan)
    shown = [g for g in found if g.measure == spec.value and _chosen(spec, g.cell)]
    everywhere = [float(_values(spec, g).mean()) for g in shown if _values(spec, g).size]
    for group in shown:
        if panel is None or group.cell[str(spec.panels)] == panel:
            values = _values(spec, group)
            if values.size:
                mean[up.index(group.cell[str(spec.y)]), across.index(group.cell[str(spec.x)])] = values.mean()
    norm = "log" if spec.log else "linear"
    image = axes.imshow(mean, origin="lower", aspect="auto", cmap="cividis", norm=norm)
    image.set_clim(min(everywhere), max(everywhere))
    middle = np.sqrt(min(everywhere) * max(everywhere)) if spec.log else (min(everywhere) + max(everywhere)) / 2.0
    for (row, column), value in np.ndenumerate(mean):
        if np.isfinite(value):
            ink = "white" if value < middle else "black"
            axes.text(column, row, f"{value:.3g}", ha="center", va="center", fontsize=7, color=ink)
    axes.set_xticks(range(len(across)), [f"{label}" for label in across])
    axes.set_yticks(range(len(up)), [f"{label}" for label in up])
    axes.grid(visible=False)
    axes.set_xlabel(_axis_label(study, spec.x))
    axes.set_ylabel(_axis_label(study, spec.y))
    return image


def recovery(
    axes: Axes,
    study: Study,
    spec: FigureSpec,
    trials: Sequence[Trial],
    results: Sequence[TrialResult],
    panel: Value | None,
    lines: Sequence[Value | None],
) -> dict[str, Any]:
    """The level over time, mean and interval over seeds, with the event."""
    event = study.event
    assert event is not None  # a study with such a figure has one
    handles: dict[str, Any] = {}
    for line in lines:
        fixed = {axis: label for axis, label in ((spec.by, line), (spec.panels, panel)) if axis is not None}
        chosen = [r.series for t, r in zip(trials, results, strict=True) if _chosen(spec, t.labels, **fixed)]
        length = min(len(series) for series in chosen)
        level = 1e3 * np.array([series[:length] for series in chosen])
        t = study.warmup + SERIES_INTERVAL * np.arange(length)
        look = _look(study, spec, line)
        # On a logarithmic axis the mean of the logarithms: its interval does not reach below zero.
        values = np.log(np.maximum(level, LEAST)) if spec.log else level
        over = [interval(values[:, k]) for k in range(length)]
        middle = np.array([(o.mean, o.low, o.high) for o in over if o is not None])
        middle = np.exp(middle) if spec.log else middle
        (handle,) = axes.plot(t, middle[:, 0], color=look["color"], linewidth=1.2)
        axes.fill_between(t, middle[:, 1], middle[:, 2], color=look["color"], alpha=0.2, linewidth=0)
        handles[str(line)] = handle
    axes.axvspan(event.at, event.until, color=style.GREY, alpha=0.15, linewidth=0, zorder=0)
    if event.below is not None:
        axes.axhline(event.below * 1e3, color=style.GREY, linewidth=0.8, linestyle="--", zorder=1)
    if spec.log:
        _logarithmic(axes)
    axes.set_xlabel("t [s]")
    words = f"RMS of $l_e$ over {event.window:g} s" if event.window else "$|l_e|$"
    axes.set_ylabel(f"{words}, worst robot [mm]")
    return handles
