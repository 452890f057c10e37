"""How near to an equilibrium `nash` is: what a robot could still gain by deviating alone."""

from collections.abc import Mapping, Sequence

import numpy as np

from experiments.metrics import spread
from experiments.paper.chapters import Chapter, Extent
from experiments.report.figures import Curve, over_time
from experiments.report.report import Picture, Section
from experiments.report.style import PALETTE
from experiments.report.table import Cell, Table
from experiments.trials.result import Signals
from experiments.trials.trial import GAP_EVERY, Trial
from formation.scenario import files

TESTS = {
    "first/nash": ("figure8", "first test, figure 8"),
    "second/nash": ("triangle-corner", "second test, sharp corner"),
    "third/nash": ("triangle-circle", "third test, circle"),
}
"""Trials of experiments/paper/replication.py along which the gap is sampled: scenario, and what they are called."""
FLOOR = 1e-16
"""Where the logarithmic axis ends: what is below is rounding."""
MILLIMETRE = 1e-3
"""What the gap is compared with: the cost of a distance error of this size, kept up over the horizon [m]."""


def _trials(extent: Extent) -> Sequence[Trial]:
    del extent  # the trials are those of the paper's own tests
    return ()


def _sections(extent: Extent, signals: Mapping[str, Signals]) -> Sequence[Section]:
    del extent
    unit = millimetre_cost()
    panels, rows = [], []
    for key, (name, title) in TESTS.items():
        trial, task = signals[key], files.load(name)
        times = np.arange(len(trial.gaps)) * GAP_EVERY * task.control_interval
        lines = [
            Curve(f"robot {i + 1}", times, np.maximum(gaps, FLOOR), PALETTE[i], ("-", "--", "-.")[i % 3])
            for i, gaps in enumerate(trial.gaps.T)
        ]
        panels.append((title, r"Nash gap $\varepsilon_i$", lines))
        found = spread(trial.gaps)
        row: tuple[Cell, ...] = (title, found.median, found.upper, found.maximum, found.median / unit)
        rows.append(row)
    return [
        Section(
            "nash-gap",
            "How near to an equilibrium",
            (
                "The Nash gap εᵢ is how much robot i could still lower its own cost Jᵢ by changing its plan alone, "
                "given the plan that it expects its neighbour to follow; at an equilibrium every gap is zero. It is "
                "sampled at 10 Hz along the trials of `nash` above. The unit of Jᵢ has no meaning, so the last column "
                f"gives the gap in units of {unit:.3g}: the cost of 1 mm of distance error over the whole horizon.",
                Picture(
                    "nash-gap",
                    over_time(panels, len(panels), log=range(len(panels)), share=True, height=2.6),
                    "**Nash gap** along the three tests; values below 10⁻¹⁶ are drawn there.",
                    "The Nash gap of each robot over time in the paper's three tests",
                ),
                Table(
                    "nash-gap",
                    "Nash gap along the trial, all robots",
                    ("trial", "median", "upper quartile", "maximum", "median, in costs of 1 mm"),
                    tuple(rows),
                ),
            ),
        )
    ]


def millimetre_cost() -> float:
    """J_i of a distance error of 1 mm at each of the N + 1 steps, and nothing else (docs/theory.md, section 5)."""
    from agents.controllers.pair_game import weights  # noqa: PLC0415  loads the kernels: only a report of `nash` needs them

    task = files.load("figure8")
    radial = weights(task)[0][3]
    return 0.5 * (task.controller.horizon + 1) * radial * MILLIMETRE**2


CHAPTER = Chapter(_trials, _sections)
