"""How every figure of this project looks, and how it is saved.

Palette, fonts, a footer with seed and version; files are the same to the last byte whenever they are drawn
from the same numbers.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from formation.scenario import registry

BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
ORANGE, SKY, PURPLE, YELLOW, BLACK, GREY = "#E69F00", "#56B4E9", "#CC79A7", "#B8A800", "#222222", "#767676"
"""Okabe and Ito (2008), told apart with any colour vision; its yellow is darkened to be seen on white."""
PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, YELLOW, GREY)
"""For whatever has no colour of its own, in this order."""
MARKERS = ("s", "^", "o", "D", "v", "P", "X", "*")
"""With the palette, so that print without colour stays readable; the first three are the paper's (fig. 3)."""

WIDTH = 7.2
"""Of a figure in the report [inch]; type of 9 points then has its size on A4 paper."""
FOOTER = 0.3
"""Height kept free for the footer [inch]."""
_RC: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same glyphs on every machine
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(color=PALETTE),
    "axes.formatter.useoffset": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.color": "#333333",
    "ytick.color": "#333333",
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "figure.dpi": 100,
    "savefig.dpi": 160,
    "savefig.facecolor": "white",
    "svg.hashsalt": "echelon",  # ids in the file depend on what is drawn alone
    "svg.fonttype": "path",  # looks the same wherever it is opened
    "path.simplify_threshold": 0.3,
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw and save in here: what is drawn has this project's style and nothing of the user's own matplotlibrc."""
    with mpl.rc_context():
        mpl.rcdefaults()
        parameters: Any = mpl.rcParams
        parameters.update(_RC)
        yield


def figure(height: float, *, width: float = WIDTH) -> Figure:
    """An empty figure [inch] that leaves room for the footer; it belongs to no window and no pyplot."""
    made = Figure(figsize=(width, height), layout="constrained")
    engine: Any = made.get_layout_engine()
    engine.set(rect=(0.0, FOOTER / height, 1.0, 1.0 - FOOTER / height))
    return made


def controllers() -> dict[str, str]:
    """The colour of every controller that has one: the same in every figure."""
    return {name: f"#{spec.colour}" for name, spec in registry.CONTROLLERS.items() if spec.colour}


def colour(name: str, others: Sequence[str] = ()) -> str:
    """The colour of a controller; of anything else, by its place among `others`."""
    if name in (known := controllers()):
        return known[name]
    return PALETTE[list(others).index(name) % len(PALETTE)] if name in others else GREY


def outside_legend(axes: Axes, **more: Any) -> None:
    """A legend in one row above the axes, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    columns = min(len(labels), 6)
    axes.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, **more)


def release() -> str:
    """The version of this project, as figures and reports state it."""
    try:
        return version("echelon-formations")
    except PackageNotFoundError:  # run from a folder that nobody installed
        return "not installed"


def save(drawn: Figure, stem: Path, note: str = "") -> list[Path]:
    """Write `stem`.png and `stem`.svg, with a footer; the same figure gives the same bytes.

    Args:
        drawn: made by `figure` inside `styled()`; `save` is called there too.
        stem: path without suffix; its folder exists.
        note: text of the footer before the version, such as "triangle-circle, seeds 0 to 9".

    Returns:
        The two files.
    """
    text = " · ".join(part for part in (note, f"echelon {release()}") if part)
    drawn.text(0.995, 0.06 / drawn.get_figheight(), text, ha="right", va="bottom", fontsize=6.5, color=GREY)
    _settle(drawn)
    png, svg = stem.with_name(f"{stem.name}.png"), stem.with_name(f"{stem.name}.svg")
    drawn.savefig(png, metadata={"Software": None})
    drawn.savefig(svg, metadata={"Date": None, "Creator": None})
    return [png, svg]


def _settle(drawn: Figure) -> None:
    """Lay the figure out once and for all, in places without last bits.

    The layout's solver gives positions whose last bits differ from call to call, and ids in an SVG hang on them.
    """
    drawn.draw_without_rendering()
    drawn.set_layout_engine("none")
    for axes in drawn.axes:
        x, y, width, height = (round(float(bound), 6) for bound in axes.get_position(original=True).bounds)
        axes.set_position((x, y, width, height))
