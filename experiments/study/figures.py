"""Figures of a study: one per [[figures]] of its file, in panels, with a legend above."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.report import style
from experiments.study.intervals import groups
from experiments.study.panels import bands, recovery, surface, value_label, with_unit
from experiments.study.study import FigureSpec, Study, Value
from experiments.study.table import Row
from experiments.trials.result import TrialResult
from experiments.trials.trial import Trial

PANEL_HEIGHT, TITLE_HEIGHT, LEGEND_ROW = 2.7, 0.26, 0.23
"""[inch]"""
ACROSS = 3
"""Panels beside each other."""
LEGEND_LETTERS, LEGEND_HANDLE = 100, 7
"""About so many letters fit into the width of a figure, and as many as the line beside a text is wide."""


def draw(
    study: Study, trials: Sequence[Trial], results: Sequence[TrialResult], table: Sequence[Row], folder: Path
) -> list[Path]:
    """Draw every figure of the study into a folder.

    Returns:
        The files.
    """
    found = groups(study, table)
    files: list[Path] = []
    with style.styled():
        for spec in study.figures:
            panels, lines = _labels(study, spec, spec.panels), _labels(study, spec, spec.by)
            made, grid = _canvas(spec, panels, lines)
            handles: dict[str, Any] = {}
            image = None
            for axes, panel in zip(grid, panels, strict=False):
                if spec.kind == "recovery":
                    handles |= recovery(axes, study, spec, trials, results, panel, lines)
                elif spec.kind == "surface":
                    image = surface(axes, study, spec, found, panel)
                else:
                    handles |= bands(axes, study, spec, found, panel, lines)
                axes.label_outer()
                if panel is not None:
                    axes.set_title(f"{spec.panels} {with_unit(study, spec.panels, panel)}", fontweight="normal")
            if image is not None:
                scale = made.colorbar(image, ax=grid, label=value_label(spec))
                scale.ax.yaxis.set_major_formatter("{x:g}")
                scale.ax.yaxis.set_minor_formatter("{x:g}")
            elif spec.by:
                top = 1.0 - TITLE_HEIGHT / made.get_figheight()
                columns = _legend_columns(lines)
                made.legend(
                    handles.values(), handles.keys(), loc="upper left", bbox_to_anchor=(0.0, top), ncols=columns
                )
            files += style.save(made, folder / spec.name, _note(study, spec))
    return files


def _canvas(spec: FigureSpec, panels: Sequence[Value | None], lines: Sequence[Value | None]) -> tuple[Any, list[Any]]:
    """A figure with its title and room for its legend, and the axes of its panels."""
    across = min(len(panels), ACROSS)
    down = -(-len(panels) // across)
    legend = -(-len(lines) // _legend_columns(lines)) * LEGEND_ROW if spec.by else 0.0
    height = style.FOOTER + TITLE_HEIGHT + legend + down * PANEL_HEIGHT
    made = style.figure(height)
    engine: Any = made.get_layout_engine()
    engine.set(rect=(0.0, style.FOOTER / height, 1.0, down * PANEL_HEIGHT / height))
    made.text(0.01, 1.0 - 0.05 / height, spec.title or spec.name, va="top", fontsize=10, fontweight="bold")
    grid = made.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for axes in list(grid.flat)[len(panels) :]:
        axes.set_visible(False)
    return made, list(grid.flat)


def _note(study: Study, spec: FigureSpec) -> str:
    seeds = "seed 0" if study.seeds == 1 else f"seeds 0 to {study.seeds - 1}"
    mean = "geometric mean" if spec.kind == "recovery" and spec.log else "mean"
    band = f" · {mean} and its 95 % confidence" if study.seeds > 1 and spec.kind != "surface" else ""
    return f"study {study.name}, {seeds}{band}"


def _labels(study: Study, spec: FigureSpec, axis: str | None) -> list[Value | None]:
    """What is drawn of an axis."""
    if axis is None:
        return [None]
    return [label for label in study.labels[axis] if label in spec.only.get(axis, study.labels[axis])]


def _legend_columns(lines: Sequence[Value | None]) -> int:
    """So many entries find room beside each other."""
    widths = [len(str(line)) + LEGEND_HANDLE for line in lines]
    return len(lines) if sum(widths) <= LEGEND_LETTERS else max(1, LEGEND_LETTERS // max(widths))
