"""Section 4 of the paper, flown again: figs. 3 to 11."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.metrics import Spread, rms, spread
from experiments.paper import claims
from experiments.paper.bounds import bounds
from experiments.paper.chapters import Chapter, Extent, controllers
from experiments.report.figures import BOX_FLOOR, EVERY, FLOOR, MILLI, Line, boxes, error_lines, over_time, trajectories
from experiments.report.report import Picture, Section
from experiments.report.style import PALETTE, colour
from experiments.report.table import Cell, Table
from experiments.trials.trial import Trial, TrialResult
from formation.arrays import FloatArray
from formation.scenario import files

PATHS = {"figure8": "1: '8'", "circle": "2: circle", "sinusoid": "3: sinusoid", "spiral": "4: spiral"}
"""Scenario of each reference path, and what the paper's Table 1 calls it."""
FIRST, SECOND, THIRD = ("leader_follower", "paper", "nash"), ("paper", "nash"), ("paper", "nash")
BOXES = ("leader_follower", "paper", "nash", "centralised")
CORNER, CIRCLE = "triangle-corner", "triangle-circle"


def _orders(extent: Extent) -> list[Trial]:
    flown = [("first", "figure8", FIRST), ("second", CORNER, SECOND), ("third", CIRCLE, THIRD)]
    orders = [
        extent.order(f"{test}/{name}", task, f"controller.name={name}", gap=name == "nash")
        for test, task, names in flown
        for name in names
    ]
    orders += [
        extent.order(f"box/{path}/{name}", path, f"controller.name={name}", in_formation=True)
        for path in PATHS
        for name in controllers(BOXES)
    ]
    return orders


def _sections(extent: Extent, flown: Mapping[str, TrialResult]) -> list[Section]:
    del extent  # every flight is in `flown`
    return [
        _first({name: flown[f"first/{name}"] for name in FIRST}),
        _statistics({path: {name: flown[f"box/{path}/{name}"] for name in controllers(BOXES)} for path in PATHS}),
        _second(flown["second/paper"], flown["second/nash"]),
        _third(flown["third/paper"], flown["third/nash"]),
    ]


CHAPTER = Chapter(_orders, _sections)


def _first(flights: Mapping[str, TrialResult]) -> Section:
    paper, nash, follower = flights["paper"], flights["nash"], flights["leader_follower"]
    start = float(np.abs(nash.distance[0]).max())
    return Section(
        "first-test",
        "First test: two robots on the figure 8 (figs. 3 to 5)",
        (
            "Two robots side by side, 0.1 m apart, on reference path 1; N = 20, ΔT = 0.1 s, δt = 0.01 s, so the "
            f"horizon is 2 s. The printed start poses are {claims.mm(start)} off in distance, whatever flies from "
            f"there, so measures begin after {claims.SETTLING:g} s. `paper` is the algorithm as printed, on test data "
            "that are consistent ([errata 6 to 11](#errata) mended).",
            Picture(
                "fig03-trajectories",
                trajectories([("paper, as printed", paper), ("nash", nash)], 5.0, follower),
                "**Fig. 3 again.** A marker every 5 s. The dashed line is the follower of the leader-follower law.",
                "Trajectories of two robots on a figure 8, for paper and for nash, with the leader-follower's follower",
            ),
            claims.both_objectives(flights),
            Picture(
                "fig04-inputs",
                _inputs([("paper, as printed", paper), ("nash", nash)]),
                "**Fig. 4 again.** Linear and angular velocity of both robots.",
                "Inputs v and omega of both robots over time, for paper and for nash",
            ),
            claims.turns(flights),
            Picture(
                "fig05-pattern-errors",
                _pattern_errors(flights),
                "**Fig. 5 again.** Pattern errors of robot 1; above as the paper draws them, below their size on a "
                "logarithmic axis.",
                "Distance and angle errors over time for leader-follower, paper and nash",
            ),
            claims.follower_errs(flights),
        ),
    )


def _inputs(panels: Sequence[tuple[str, TrialResult]]) -> Figure:
    drawn = []
    for column, (label, unit) in enumerate((("v", "m/s"), (r"\omega", "rad/s"))):
        for title, flown in panels:
            lines = [
                Line(f"robot {i + 1}", flown.times[:-1:EVERY], values[::EVERY], PALETTE[i], "--" if i else "-")
                for i, values in enumerate(flown.inputs[..., column].T)
            ]
            drawn.append((title, f"${label}$ [{unit}]", lines))
    return over_time(drawn, len(panels), share=True)


def _pattern_errors(flights: Mapping[str, TrialResult]) -> Figure:
    lines: dict[tuple[int, int], list[Line]] = {(row, column): [] for row in (0, 1) for column in (0, 1)}
    for name, flown in flights.items():
        signals = (flown.distance[::EVERY, 0] * MILLI, flown.angle[::EVERY, 0])
        for column, (signal, floor) in enumerate(zip(signals, (FLOOR, FLOOR / 10.0), strict=True)):
            for row, values in enumerate((signal, np.maximum(np.abs(signal), floor))):
                line = Line(
                    name, flown.times[::EVERY], values, colour(name), "--" if name == "leader_follower" else "-"
                )
                lines[row, column].append(line)
    labels = {(0, 0): "$l_e$ [mm]", (0, 1): r"$\psi_e$ [rad]", (1, 0): "$|l_e|$ [mm]", (1, 1): r"$|\psi_e|$ [rad]"}
    titles = {(0, 0): "distance error", (0, 1): "angle error", (1, 0): "its size", (1, 1): "its size"}
    panels = [(titles[place], labels[place], lines[place]) for place in labels]
    return over_time(panels, 2, log=(2, 3))


def _statistics(paths: Mapping[str, Mapping[str, TrialResult]]) -> Section:
    table, verdict = bounds(paths)
    return Section(
        "statistics",
        "Pattern errors on the four reference paths (figs. 6 and 7)",
        (
            "Two robots side by side on each path of Table 1 (path 4 with its missing factor t, "
            "[erratum 9](#errata)), whole flights from a start in formation: for paths 2 to 4 the paper states no "
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
    paths: Mapping[str, Mapping[str, TrialResult]], what: str, scale: float
) -> dict[str, dict[str, tuple[Spread, Spread]]]:
    """Of signed errors and of their size, by path and controller."""
    return {
        PATHS[path]: {
            name: (spread(getattr(flown, what) * scale), spread(np.abs(getattr(flown, what)) * scale))
            for name, flown in flights.items()
        }
        for path, flights in paths.items()
    }


def _spread_table(
    name: str, caption: str, paths: Mapping[str, Mapping[str, TrialResult]], what: str, scale: float
) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for path, found in _spreads(paths, what, scale).items():
        for controller, (_, size) in found.items():
            rows.append((path, controller, size.lower, size.median, size.upper, size.rms, size.maximum))
    heads = ("path", "controller", "lower quartile", "median", "upper quartile", "RMS", "maximum")
    return Table(name, caption, heads, tuple(rows))


def _second(paper: TrialResult, nash: TrialResult) -> Section:
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
                "**Fig. 8 again.** A marker every 5 s; beside each flight its corner, enlarged.",
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


def _third(paper: TrialResult, nash: TrialResult) -> Section:
    spacing = files.load(CIRCLE).formation.spacing
    panels = [("paper, as printed", paper), ("nash", nash)]
    names = ("1st", "2nd", "3rd", "4th")
    rows: list[tuple[Cell, ...]] = [
        (name, *(size * MILLI for size in claims.quarters(flown))) for name, flown in (("paper", paper), ("nash", nash))
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


def _distance_errors(panels: Sequence[tuple[str, TrialResult]]) -> Figure:
    """Figs. 9 and 11, with a second row on a logarithmic axis."""
    upper = [(title, "$l_e$ [mm]", error_lines(flown)) for title, flown in panels]
    lower = [("", "$|l_e|$ [mm]", error_lines(flown, size=True)) for _, flown in panels]
    log = range(len(panels), 2 * len(panels))
    return over_time([*upper, *lower], len(panels), log=tuple(log), share=True)
