"""A robot that stands still for four seconds: how the formation fares (docs/theory.md, section 15)."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.metrics import recovery
from experiments.paper.chapters import IN_FORMATION, Chapter, Extent, controller, controllers
from experiments.paper.claims import mm
from experiments.report.figures import EVERY, FLOOR, Curve, over_time
from experiments.report.report import Picture, Section, Verdict, grade
from experiments.report.style import GREY, SKY, colour
from experiments.report.table import Cell, Table
from experiments.trials.result import Signals
from experiments.trials.trial import Trial
from formation.scenario.overrides import Overrides, merged

AT, UNTIL = 20.0, 24.0
"""When the robot stands still [s]."""
LATE = 0.5
"""[s]."""
SMALL = 2e-3
"""Back in formation: all |l_e| at most this [m]."""
CAUGHT_UP = 5e-3
"""Back on the path: the centre is at most this far from where it should be [m]."""
FRESH, HURRIED = "nash, plans as if fresh", "nash that does not wait"
VARIANTS = {FRESH: (SKY, "--"), HURRIED: (GREY, "-.")}
"""How they are drawn."""
LINKS = {"on time": 0.0, "0.5 s late": LATE}


def _contenders() -> dict[str, Overrides]:
    """Overrides by what the report calls them."""
    found = {name: controller(name) for name in controllers()}
    found[FRESH] = merged(controller("nash"), {"controller": {"age_plans": False}})
    found[HURRIED] = merged(controller("nash"), {"controller": {"waits": False}})
    return found


def _trials(extent: Extent) -> Sequence[Trial]:
    stuck = {"disturbances": [{"robot": 2, "at": AT, "until": UNTIL, "drive": 0.0}]}
    return [
        extent.trial(
            f"stuck/{name}/{link}",
            "triangle-circle",
            {"duration": 50},
            stuck,
            {"link": {"latency": latency}},
            overrides,
            IN_FORMATION,
        )
        for name, overrides in _contenders().items()
        for link, latency in LINKS.items()
    ]


def _sections(extent: Extent, signals: Mapping[str, Signals]) -> Sequence[Section]:
    del extent
    found = {(name, link): signals[f"stuck/{name}/{link}"] for name in _contenders() for link in LINKS}
    return [
        Section(
            "stuck",
            "A robot that cannot keep up",
            (
                f"The triangle on the circle; robot 2 stands still from {AT:g} to {UNTIL:g} s, although "
                "it is commanded to drive. No noise, a start in formation. Here messages matter: the others "
                "can only wait for a robot whose plans they receive.",
                Picture(
                    "stuck",
                    _drawn(found),
                    f"**Robot 2 is stuck** from {AT:g} to {UNTIL:g} s (shaded). Worst |lₑ| of the three pairs.",
                    "Worst distance error over time by controller, with plans on time and half a second late",
                ),
                table(found),
                ledger(found),
                verdict(found),
                worth_of_messages(found),
            ),
        )
    ]


def _drawn(found: Mapping[tuple[str, str], Signals]) -> Figure:
    panels = []
    for link in LINKS:
        lines = []
        for name in _contenders():
            trial = found[name, link]
            rows = slice(trial.after(AT - 5.0).start, trial.after(UNTIL + 20.0).stop, EVERY)
            worst = np.maximum(np.abs(trial.distance[rows]).max(axis=1) * 1e3, FLOOR)
            ink, style = VARIANTS.get(name) or (colour(name), "-")
            lines.append(Curve(name, trial.times[rows], worst, ink, style))
        panels.append((f"plans {link}", "worst $|l_e|$ [mm]", lines))
    drawn = over_time(panels, len(panels), log=range(len(panels)), share=True, height=3.0)
    for axes in drawn.axes:
        axes.axvspan(AT, UNTIL, color="#888888", alpha=0.15, linewidth=0)
    return drawn


def measure(trial: Signals) -> tuple[float, float | None, float | None]:
    """Worst |l_e| from `AT` on [m]; seconds from `UNTIL` until all are small for good; until the path is caught up."""
    size = np.abs(trial.distance).max(axis=1)
    again = recovery(trial.times, size, below=SMALL, since=UNTIL)
    path = recovery(trial.times, trial.tracking, below=CAUGHT_UP, since=UNTIL)
    return float(size[trial.after(AT)].max()), again, path


def table(found: Mapping[tuple[str, str], Signals]) -> Table:
    """A row per controller, its measures with plans on time and late."""
    rows: list[tuple[Cell, ...]] = []
    for name in dict.fromkeys(name for name, _ in found):
        row: list[Cell] = [name]
        for link in LINKS:
            worst, again, path = measure(found[name, link])
            row += [worst * 1e3, "never" if again is None else again, "never" if path is None else path]
        rows.append(tuple(row))
    heads = ("worst |lₑ| mm", "in formation after s", "on the path after s")
    return Table(
        "stuck",
        f"Seconds count from the release; in formation: all |lₑ| ≤ {SMALL * 1e3:g} mm, on the path: centre within "
        f"{CAUGHT_UP * 1e3:g} mm, both to the end of the trial",
        ("controller", *(f"{link}: {head}" for link in LINKS for head in heads)),
        tuple(rows),
    )


def ledger(found: Mapping[tuple[str, str], Signals]) -> Table:
    """A row per excursion of `nash`: whose error rose above its limit, and the likely cause by the ledger."""
    rows: list[tuple[Cell, ...]] = [
        (
            f"plans {link}",
            f"robot {one.robot}",
            one.at,
            one.peak * 1e3,
            "never" if one.recovery is None else one.recovery,
            one.cause or "none found",
        )
        for link in LINKS
        for one in found["nash", link].excursions
    ]
    return Table(
        "stuck_ledger",
        "The ledger of `nash`, as the page and summaries have it: errors of a robot above its limit "
        "(`metrics.excursion`), and the likely cause by the rule of docs/theory.md, section 9; recovery counts from "
        "the end of the cause",
        ("links", "whose error", "from s", "largest mm", "recovered after s", "likely cause"),
        tuple(rows),
    )


def worth_of_messages(found: Mapping[tuple[str, str], Signals]) -> str:
    """What messages are worth here, and what ageing them does, in the numbers of these trials."""
    waits, alone, own, fresh = (
        [mm(measure(found[name, link])[0]) for link in LINKS] for name in ("nash", HURRIED, "virtual_structure", FRESH)
    )
    return (
        f"What messages are worth: the others wait. `nash` keeps the worst error at {waits[0]} with plans on time and "
        f"{waits[1]} with plans {LATE:g} s late, against {own[0]} of robots without messages (`virtual_structure`). "
        f"Robots that know the neighbour's place but do not wait gain little ({alone[0]}): the path does not wait, "
        f"and each follows its own slot. Ageing the plans changes little here ({fresh[0]} and {fresh[1]} when they "
        "are taken as if fresh): a plan also carries how far its robot is behind, which is of use even when the "
        "plan is old. The effect of ageing shows under noise, [below](#late-and-lost): the centre stays on the path."
    )


def verdict(found: Mapping[tuple[str, str], Signals]) -> Verdict:
    """What this project claims of `nash` with a stuck robot."""
    worst, again, path = measure(found["nash", "on time"])
    late, again_late, path_late = measure(found["nash", "0.5 s late"])
    seconds = ["never" if s is None else f"{s:.1f} s" for s in (again, again_late, path, path_late)]
    return Verdict(
        "This project: with a robot stuck for 4 s the worst |lₑ| of `nash` is at most 25 mm with plans on time and "
        "50 mm with plans 0.5 s late; all are below 2 mm within 4 s of its release; the path is caught up afterwards.",
        f"On time the worst is {mm(worst)}, late {mm(late)}; back below 2 mm after {seconds[0]} and {seconds[1]}; the "
        f"path caught up after {seconds[2]} and {seconds[3]}.",
        grade(
            [
                worst <= 0.025,
                late <= 0.050,
                again is not None and again <= 4.0,
                again_late is not None and again_late <= 4.0,
                path is not None and path_late is not None,
            ]
        ),
    )


CHAPTER = Chapter(_trials, _sections)
