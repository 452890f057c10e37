"""Figures of a study: one picture per wish of its file, in panels, with a legend above."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.report import style
from experiments.study.flights import Result
from experiments.study.grid import Job
from experiments.study.intervals import groups
from experiments.study.panels import bands, recovery, surface, value_label, with_unit
from experiments.study.study import Figure, Study, Value
from experiments.study.table import Row

PANEL_HEIGHT, TITLE_HEIGHT, LEGEND_ROW = 2.7, 0.26, 0.23
"""[inch]"""
ACROSS = 3
"""Panels beside each other."""
LEGEND_LETTERS, LEGEND_HANDLE = 100, 7
"""About so many letters fit into the width of a figure, and as many as the line beside a text is wide."""


def draw(
    study: Study, jobs: Sequence[Job], results: Sequence[Result], table: Sequence[Row], folder: Path
) -> list[Path]:
    """Draw every figure of the study into a folder.

    Returns:
        The files.
    """
    found = groups(study, table)
    files: list[Path] = []
    with style.styled():
        for wish in study.figures:
            panels, lines = _labels(study, wish, wish.panels), _labels(study, wish, wish.by)
            made, grid = _canvas(wish, panels, lines)
            handles: dict[str, Any] = {}
            image = None
            for axes, panel in zip(grid, panels, strict=False):
                if wish.kind == "recovery":
                    handles |= recovery(axes, study, wish, jobs, results, panel, lines)
                elif wish.kind == "surface":
                    image = surface(axes, study, wish, found, panel)
                else:
                    handles |= bands(axes, study, wish, found, panel, lines)
                axes.label_outer()
                if panel is not None:
                    axes.set_title(f"{wish.panels} {with_unit(study, wish.panels, panel)}", fontweight="normal")
            if image is not None:
                scale = made.colorbar(image, ax=grid, label=value_label(wish))
                scale.ax.yaxis.set_major_formatter("{x:g}")
                scale.ax.yaxis.set_minor_formatter("{x:g}")
            elif wish.by:
                top = 1.0 - TITLE_HEIGHT / made.get_figheight()
                columns = _legend_columns(lines)
                made.legend(
                    handles.values(), handles.keys(), loc="upper left", bbox_to_anchor=(0.0, top), ncols=columns
                )
            files += style.save(made, folder / wish.name, _note(study, wish))
    return files


def _canvas(wish: Figure, panels: Sequence[Value | None], lines: Sequence[Value | None]) -> tuple[Any, list[Any]]:
    """A figure with its title and room for its legend, and the axes of its panels."""
    across = min(len(panels), ACROSS)
    down = -(-len(panels) // across)
    legend = -(-len(lines) // _legend_columns(lines)) * LEGEND_ROW if wish.by else 0.0
    height = style.FOOTER + TITLE_HEIGHT + legend + down * PANEL_HEIGHT
    made = style.figure(height)
    engine: Any = made.get_layout_engine()
    engine.set(rect=(0.0, style.FOOTER / height, 1.0, down * PANEL_HEIGHT / height))
    made.text(0.01, 1.0 - 0.05 / height, wish.title or wish.name, va="top", fontsize=10, fontweight="bold")
    grid = made.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for axes in list(grid.flat)[len(panels) :]:
        axes.set_visible(False)
    return made, list(grid.flat)


def _note(study: Study, wish: Figure) -> str:
    seeds = "seed 0" if study.seeds == 1 else f"seeds 0 to {study.seeds - 1}"
    mean = "geometric mean" if wish.kind == "recovery" and wish.log else "mean"
    band = f" · {mean} and its 95 % confidence" if study.seeds > 1 and wish.kind != "surface" else ""
    return f"study {study.name}, {seeds}{band}"


def _labels(study: Study, wish: Figure, axis: str | None) -> list[Value | None]:
    """What is drawn of an axis."""
    if axis is None:
        return [None]
    return [label for label in study.labels[axis] if label in wish.only.get(axis, study.labels[axis])]


def _legend_columns(lines: Sequence[Value | None]) -> int:
    """So many entries find room beside each other."""
    widths = [len(str(line)) + LEGEND_HANDLE for line in lines]
    return len(lines) if sum(widths) <= LEGEND_LETTERS else max(1, LEGEND_LETTERS // max(widths))
