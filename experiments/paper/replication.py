"""Section 4 of the paper, simulated again: figs. 3 to 11."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.metrics import Spread, spread
from experiments.paper import claims
from experiments.paper.bounds import bounds
from experiments.paper.chapters import IN_FORMATION, Chapter, Extent, controller, controllers
from experiments.report.figures import (
    BOX_FLOOR,
    EVERY,
    FLOOR,
    MILLI,
    Curve,
    boxes,
    error_lines,
    over_time,
    trajectories,
)
from experiments.report.report import Picture, Section
from experiments.report.style import PALETTE, colour
from experiments.report.table import Cell, Table
from experiments.trials.result import Signals
from experiments.trials.trial import Trial
from formation.arrays import FloatArray
from formation.metrics import rms
from formation.scenario import files

PATHS = {"figure8": "1: '8'", "circle": "2: circle", "sinusoid": "3: sinusoid", "spiral": "4: spiral"}
"""Scenario of each reference path, and what the paper's Table 1 calls it."""
FIRST, SECOND, THIRD = ("leader_follower", "paper", "nash"), ("paper", "nash"), ("paper", "nash")
BOXES = ("leader_follower", "paper", "nash", "centralised")
CORNER, CIRCLE = "triangle-corner", "triangle-circle"


def _trials(extent: Extent) -> list[Trial]:
    tests = [("first", "figure8", FIRST), ("second", CORNER, SECOND), ("third", CIRCLE, THIRD)]
    return [
        *(
            extent.trial(f"{test}/{name}", scenario, controller(name), gap=name == "nash")
            for test, scenario, names in tests
            for name in names
        ),
        *(
            extent.trial(f"box/{path}/{name}", path, controller(name), IN_FORMATION)
            for path in PATHS
            for name in controllers(BOXES)
        ),
    ]


def _sections(extent: Extent, signals: Mapping[str, Signals]) -> list[Section]:
    del extent  # every trial is in `signals`
    return [
        _first({name: signals[f"first/{name}"] for name in FIRST}),
        _statistics({path: {name: signals[f"box/{path}/{name}"] for name in controllers(BOXES)} for path in PATHS}),
        _second(signals["second/paper"], signals["second/nash"]),
        _third(signals["third/paper"], signals["third/nash"]),
    ]


CHAPTER = Chapter(_trials, _sections)


def _first(trials: Mapping[str, Signals]) -> Section:
    paper, nash, follower = trials["paper"], trials["nash"], trials["leader_follower"]
    start = float(np.abs(nash.distance[0]).max())
    return Section(
        "first-test",
        "First test: two robots on the figure 8 (figs. 3 to 5)",
        (
            "Two robots side by side, 0.1 m apart, on reference path 1; N = 20, ΔT = 0.1 s, δt = 0.01 s, so the "
            f"horizon is 2 s. The printed start poses are {claims.mm(start)} off in distance, whatever the "
            f"controller, so measures begin after {claims.SETTLING:g} s. `paper` is the algorithm as printed, on test "
            "data that are consistent ([errata 6 to 11](#errata) mended).",
            Picture(
                "fig03-trajectories",
                trajectories([("paper, as printed", paper), ("nash", nash)], 5.0, follower),
                "**Fig. 3 again.** A marker every 5 s. The dashed line is the follower of the leader-follower law.",
                "Trajectories of two robots on a figure 8, for paper and for nash, with the leader-follower's follower",
            ),
            claims.both_objectives(trials),
            Picture(
                "fig04-inputs",
                _inputs([("paper, as printed", paper), ("nash", nash)]),
                "**Fig. 4 again.** Linear and angular velocity of both robots.",
                "Inputs v and omega of both robots over time, for paper and for nash",
            ),
            claims.turns(trials),
            Picture(
                "fig05-pattern-errors",
                _pattern_errors(trials),
                "**Fig. 5 again.** Pattern errors of robot 1; above as the paper draws them, below their size on a "
                "logarithmic axis.",
                "Distance and angle errors over time for leader-follower, paper and nash",
            ),
            claims.follower_errs(trials),
        ),
    )


def _inputs(panels: Sequence[tuple[str, Signals]]) -> Figure:
    drawn = []
    for column, (label, unit) in enumerate((("v", "m/s"), (r"\omega", "rad/s"))):
        for title, trial in panels:
            lines = [
                Curve(f"robot {i + 1}", trial.times[:-1:EVERY], values[::EVERY], PALETTE[i], "--" if i else "-")
                for i, values in enumerate(trial.inputs[..., column].T)
            ]
            drawn.append((title, f"${label}$ [{unit}]", lines))
    return over_time(drawn, len(panels), share=True)


def _pattern_errors(trials: Mapping[str, Signals]) -> Figure:
    lines: dict[tuple[int, int], list[Curve]] = {(row, column): [] for row in (0, 1) for column in (0, 1)}
    for name, trial in trials.items():
        signals = (trial.distance[::EVERY, 0] * MILLI, trial.angle[::EVERY, 0])
        for column, (signal, floor) in enumerate(zip(signals, (FLOOR, FLOOR / 10.0), strict=True)):
            for row, values in enumerate((signal, np.maximum(np.abs(signal), floor))):
                line = Curve(
                    name, trial.times[::EVERY], values, colour(name), "--" if name == "leader_follower" else "-"
                )
                lines[row, column].append(line)
    labels = {(0, 0): "$l_e$ [mm]", (0, 1): r"$\psi_e$ [rad]", (1, 0): "$|l_e|$ [mm]", (1, 1): r"$|\psi_e|$ [rad]"}
    titles = {(0, 0): "distance error", (0, 1): "angle error", (1, 0): "its size", (1, 1): "its size"}
    panels = [(titles[place], labels[place], lines[place]) for place in labels]
    return over_time(panels, 2, log=(2, 3))


def _statistics(paths: Mapping[str, Mapping[str, Signals]]) -> Section:
    table, verdict = bounds(paths)
    return Section(
        "statistics",
        "Pattern errors on the four reference paths (figs. 6 and 7)",
        (
            "Two robots side by side on each path of Table 1 (path 4 with its missing factor t, "
            "[erratum 9](#errata)), whole trials from a start in formation: for paths 2 to 4 the paper states no "
            "start. Boxes are quartiles, whiskers the range, as the paper states; both robots together.",
            Picture(
                "fig06-distance-errors",
                boxes(_spreads(paths, "distance", MILLI), "$l_e$ [mm]", BOX_FLOOR),
                "**Fig. 6 again.** Distance errors; below, their size on a logarithmic axis.",
                "Box-and-whisker plots of the distance error by path and controller",
            ),
            claims.boxes_smaller(paths, "distance"),
            Picture(
                "fig07-angle-errors",
                boxes(_spreads(paths, "angle", 1.0), r"$\psi_e$ [rad]", BOX_FLOOR / 10.0),
                "**Fig. 7 again.** Angle errors; below, their size on a logarithmic axis.",
                "Box-and-whisker plots of the angle error by path and controller",
            ),
            claims.boxes_smaller(paths, "angle"),
            _spread_table("distance-errors", "Size of the distance error |lₑ| [mm]", paths, "distance", MILLI),
            _spread_table("angle-errors", "Size of the angle error |ψₑ| [mrad]", paths, "angle", MILLI),
            verdict,
            table,
        ),
    )


def _spreads(
    paths: Mapping[str, Mapping[str, Signals]], what: str, scale: float
) -> dict[str, dict[str, tuple[Spread, Spread]]]:
    """Of signed errors and of their size, by path and controller."""
    return {
        PATHS[path]: {
            name: (spread(getattr(trial, what) * scale), spread(np.abs(getattr(trial, what)) * scale))
            for name, trial in trials.items()
        }
        for path, trials in paths.items()
    }


def _spread_table(
    name: str, caption: str, paths: Mapping[str, Mapping[str, Signals]], what: str, scale: float
) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for path, found in _spreads(paths, what, scale).items():
        for method, (_, size) in found.items():
            rows.append((path, method, size.lower, size.median, size.upper, size.rms, size.maximum))
    heads = ("path", "controller", "lower quartile", "median", "upper quartile", "RMS", "maximum")
    return Table(name, caption, heads, tuple(rows))


def _second(paper: Signals, nash: Signals) -> Section:
    task = files.load(CORNER)
    corner, spacing = float(task.path.model_dump()["at"]), task.formation.spacing
    panels = [("paper, as printed", paper), ("nash", nash)]
    return Section(
        "second-test",
        "Second test: a triangle round a sharp corner (figs. 8 and 9)",
        (
            f"Three robots, 0.1 m apart, follow a path that turns by 45° on the spot at t = {corner:g} s, and whose "
            "speed rises from 0.1 to 0.14 m/s there. The virtual centre is the centroid "
            "([erratum 6](#errata)).",
            Picture(
                "fig08-trajectories",
                trajectories(panels, 5.0, zoom=_around(task.path.position(np.array(corner)))),
                "**Fig. 8 again.** A marker every 5 s; beside each trajectory its corner, enlarged.",
                "Trajectories of three robots round a sharp corner, for paper and for nash",
            ),
            Picture(
                "fig09-distance-errors",
                _distance_errors(panels),
                "**Fig. 9 again.** Distance errors of the three pairs; below, their size on a logarithmic axis.",
                "Distance errors of three pairs over time, for paper and for nash",
            ),
            claims.corner_recovers(paper, spacing, corner),
            claims.corner_beaten(nash, corner),
        ),
    )


def _around(point: FloatArray) -> tuple[float, float, float, float]:
    """Limits of a view of 0.7 m around a point (2,)."""
    x, y = point.tolist()
    return x - 0.25, x + 0.45, y - 0.45, y + 0.25


def _third(paper: Signals, nash: Signals) -> Section:
    spacing = files.load(CIRCLE).formation.spacing
    panels = [("paper, as printed", paper), ("nash", nash)]
    names = ("1st", "2nd", "3rd", "4th")
    rows: list[tuple[Cell, ...]] = [
        (name, *(size * MILLI for size in claims.quarters(trial))) for name, trial in (("paper", paper), ("nash", nash))
    ]
    return Section(
        "third-test",
        "Third test: a triangle on the circle (figs. 10 and 11)",
        (
            "Three robots, 0.1 m apart, one lap of reference path 2 from the printed poses, with the second test's Q "
            "([erratum 10](#errata)).",
            Picture(
                "fig10-trajectories",
                trajectories(panels, 8.0),
                "**Fig. 10 again.** A marker every 8 s.",
                "Trajectories of three robots on a circle, for paper and for nash",
            ),
            Picture(
                "fig11-distance-errors",
                _distance_errors(panels),
                "**Fig. 11 again.** Distance errors of the three pairs; below, their size on a logarithmic axis.",
                "Distance errors of three pairs over time, for paper and for nash",
            ),
            Table(
                "third-test",
                "RMS of lₑ by quarter of the lap [mm]",
                ("controller", *names),
                tuple(rows),
            ),
            claims.circle_bounded(paper, spacing),
            "`nash` settles from the same start to an error of "
            f"{claims.mm(rms(nash.distance[nash.after(nash.times[-1] / 2.0)]))} RMS in the second half of the lap.",
        ),
    )


def _distance_errors(panels: Sequence[tuple[str, Signals]]) -> Figure:
    """Figs. 9 and 11, with a second row on a logarithmic axis."""
    upper = [(title, "$l_e$ [mm]", error_lines(trial)) for title, trial in panels]
    lower = [("", "$|l_e|$ [mm]", error_lines(trial, size=True)) for _, trial in panels]
    log = range(len(panels), 2 * len(panels))
    return over_time([*upper, *lower], len(panels), log=tuple(log), share=True)
