"""What late and lost plans cost where predictions are not perfect (docs/theory.md, section 10)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from experiments.paper.chapters import IN_FORMATION, Chapter, Extent
from experiments.report.figures import bands
from experiments.report.report import Picture, Section, Verdict, grade
from experiments.report.style import BLUE, VERMILION
from experiments.report.table import Cell, Table
from experiments.trials.result import Signals
from experiments.trials.trial import Trial
from formation.arrays import FloatArray
from formation.metrics import rms
from formation.scenario.overrides import Overrides

NOISE: Overrides = {"noise": {"slip": 0.2, "gyro": 0.2, "position": 0.001, "heading": 0.01}}
"""Per tick v and omega times 1 + 0.2 n, omega plus 0.2 n rad/s; poses measured to 1 mm and 0.01 rad."""
NASH: Overrides = {"duration": 40, "controller": {"name": "nash", "plan_every": 5}}
"""A new plan every 0.05 s (docs/theory.md, section 10)."""


@dataclass(frozen=True, slots=True)
class Condition:
    """What happens to every plan on its link."""

    name: str
    latency: float = 0.0
    """[s]."""
    loss: float = 0.0
    bound: float | None = None
    """How much the RMS of l_e may grow against plans on time."""


CONDITIONS = (
    Condition("on time"),
    Condition("0.3 s late", latency=0.3),
    Condition("0.5 s late", latency=0.5, bound=0.03),
    Condition("1 s late", latency=1.0, bound=0.05),
    Condition("50 % lost", loss=0.5),
    Condition("90 % lost", loss=0.9, bound=0.05),
    Condition("0.3 s late, 50 % lost", latency=0.3, loss=0.5),
)
AGED, FRESH = "aged", "taken as if fresh"


def _trials(extent: Extent) -> Sequence[Trial]:
    return [
        extent.trial(
            _name(belief, condition, seed),
            "triangle-circle",
            NOISE,
            NASH,
            {"link": {"latency": condition.latency, "loss": condition.loss}},
            {"controller": {"age_plans": belief == AGED}},
            IN_FORMATION,
            seed=seed,
        )
        for belief in (AGED, FRESH)
        for condition in CONDITIONS
        for seed in range(extent.seeds)
    ]


def _name(belief: str, condition: Condition, seed: int) -> str:
    return f"noisy/{belief}/{condition.name}/{seed}"


def _sections(extent: Extent, signals: Mapping[str, Signals]) -> Sequence[Section]:
    found = {
        (belief, condition.name): np.array(
            [measure(signals[_name(belief, condition, seed)]) for seed in range(extent.seeds)]
        )
        for belief in (AGED, FRESH)
        for condition in CONDITIONS
    }
    seeds = f"seeds {extent.seed} to {extent.seed + extent.seeds - 1}" if extent.seeds > 1 else f"seed {extent.seed}"
    return [
        Section(
            "late-and-lost",
            "Late and lost plans, with noise",
            (
                "Without noise every prediction is perfect, and lateness costs nothing. Here wheels slip (each tick v "
                "and ω are multiplied by 1 + 0.2 n, and 0.2 n rad/s is added to ω; n is standard normal) and robots "
                "measure their poses with errors of 1 mm and 0.01 rad. A triangle drives round the circle; measured is "
                f"the second half of 40 s, {seeds}, the same noise and the same faults for every row. **Aged** plans "
                "are rolled forward along themselves by their age; the others are taken as if they had just been made.",
                Picture("late-plans", _drawn(found), _CAPTION, _ALT),
                table(found),
                verdict(found),
                "These numbers say little about messages: the heavy weight on the centre makes each robot follow its "
                "own slot, which needs no message. What messages are worth shows when a robot "
                "[cannot keep its slot](#stuck).",
            ),
        )
    ]


_CAPTION = "**Late plans.** RMS of lₑ and of the centre's distance to the path; lines are means, bands ranges."
_ALT = "RMS errors over latency, for plans that are aged and for plans taken as if fresh"


def measure(trial: Signals) -> tuple[float, float]:
    """RMS of l_e, and of the centre's distance to the path, in the second half of the trial [mm]."""
    rows = trial.after(trial.times[-1] / 2.0)
    return rms(trial.distance[rows]) * 1e3, rms(trial.tracking[rows]) * 1e3


def _drawn(found: Mapping[tuple[str, str], FloatArray]) -> Figure:
    late = [condition for condition in CONDITIONS if condition.loss == 0.0]
    x = np.array([condition.latency for condition in late])
    panels = []
    for column, title in enumerate(("distance error", "centre to path")):
        lines = [
            (belief, ink, x, np.array([found[belief, condition.name][:, column] for condition in late]))
            for belief, ink in ((AGED, BLUE), (FRESH, VERMILION))
        ]
        panels.append((title, "latency of every plan [s]", lines))
    return bands(panels, "RMS [mm]")


def growth(found: Mapping[tuple[str, str], FloatArray], belief: str, name: str) -> float:
    """Mean over seeds of how much the RMS of l_e grows against aged plans on time, seed by seed."""
    return float(np.mean(found[belief, name][:, 0] / found[AGED, CONDITIONS[0].name][:, 0])) - 1.0


def table(found: Mapping[tuple[str, str], FloatArray]) -> Table:
    """Rows are conditions; found is (seeds, 2) by belief and condition, as `measure` gives it."""
    rows: list[tuple[Cell, ...]] = []
    for condition in CONDITIONS:
        row: list[Cell] = [condition.name]
        for belief in (AGED, FRESH):
            values = found[belief, condition.name]
            row += [
                float(values[:, 0].mean()),
                100.0 * growth(found, belief, condition.name),
                float(values[:, 1].mean()),
            ]
        rows.append(tuple(row))
    heads = ("RMS lₑ mm", "growth %", "centre mm")
    return Table(
        "late-and-lost",
        "Means over seeds: RMS of lₑ, its growth against on time (paired), RMS distance of centre and path",
        ("every plan is", *(f"{belief}: {head}" for belief in (AGED, FRESH) for head in heads)),
        tuple(rows),
    )


def verdict(found: Mapping[tuple[str, str], FloatArray]) -> Verdict:
    """What this project claims of `nash` with late and lost plans."""
    bounded = [(condition, condition.bound) for condition in CONDITIONS if condition.bound is not None]
    grown = {condition.name: growth(found, AGED, condition.name) for condition, _ in bounded}
    bounds = ", ".join(f"{bound:.0%} with plans {condition.name}" for condition, bound in bounded)
    return Verdict(
        f"This project: with ageing the RMS of lₑ grows by at most {bounds}.",
        f"It grows by {', '.join(f'{grown[name]:.1%} ({name})' for name in grown)}, "
        f"over {len(next(iter(found.values())))} seeds.",
        grade([grown[condition.name] <= bound for condition, bound in bounded]),
    )


CHAPTER = Chapter(_trials, _sections)
