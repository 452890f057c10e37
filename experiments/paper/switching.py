"""Formations that change their shape while they drive: do the robots keep clear of each other?"""

from collections.abc import Mapping, Sequence

import numpy as np

from experiments.paper.chapters import IN_FORMATION, Chapter, Extent
from experiments.paper.noisy import NASH, NOISE
from experiments.report.figures import trajectories
from experiments.report.report import Picture, Section, Verdict, grade
from experiments.report.table import Cell, Table, shown
from experiments.trials.result import Signals
from experiments.trials.trial import Trial
from formation.metrics import clearance, rms
from formation.scenario import files
from formation.scenario.overrides import Overrides

CASES: dict[str, tuple[str, list[Overrides]]] = {
    "triangle, line, triangle": (
        "triangle-circle",
        [{"at": 8, "shape": "line", "robots": 3}, {"at": 24, "shape": "triangle"}],
    ),
    "square, column": ("square-figure8", [{"at": 8, "shape": "column", "robots": 4}]),
}
"""Scenario and changes of its formation."""
LATENCIES = (0.0, 0.3, 0.5)
"""Of every plan [s]."""
CLEAR = 0.4
"""No two robots come closer than this share of the spacing."""


def _name(case: str, latency: float, seed: int) -> str:
    return f"switching/{case}/{latency}/{seed}"


def _trials(extent: Extent) -> Sequence[Trial]:
    return [
        extent.trial(
            _name(case, latency, seed),
            scenario,
            NOISE,
            NASH,
            {"formation": {"changes": changes}, "link": {"latency": latency}},
            IN_FORMATION,
            seed=seed,
        )
        for case, (scenario, changes) in CASES.items()
        for latency in LATENCIES
        for seed in range(extent.seeds)
    ]


def _sections(extent: Extent, signals: Mapping[str, Signals]) -> Sequence[Section]:
    found = {
        (case, latency): [signals[_name(case, latency, seed)] for seed in range(extent.seeds)]
        for case in CASES
        for latency in LATENCIES
    }
    spacing = {case: files.load(scenario).spacing for case, (scenario, _) in CASES.items()}
    return [
        Section(
            "switching",
            "Changing shape on the way",
            (
                "The paper allows patterns that vary with time (section 2.1), and shows none. Here a triangle becomes "
                "a line and a triangle again, and a square becomes a column, with the noise of the "
                "[section above](#late-and-lost). Every robot takes the slot that makes the ways short.",
                Picture(
                    "switching",
                    trajectories([(case, found[case, 0.0][0]) for case in CASES], 4.0),
                    f"**Changes of shape**, plans on time, seed {extent.seed}; a marker every 4 s.",
                    "Trajectories of three robots that change from a triangle to a line and back, and of four from a "
                    "square to a column",
                ),
                table(found, spacing),
                verdict(found, spacing),
            ),
        )
    ]


def table(found: Mapping[tuple[str, float], Sequence[Signals]], spacing: Mapping[str, float]) -> Table:
    """A row for each case and latency."""
    rows: list[tuple[Cell, ...]] = []
    for (case, latency), trials in found.items():
        least = min(clearance(trial.poses) for trial in trials)
        ends = [rms(trial.distance[trial.after(trial.times[-1] - 5.0)]) for trial in trials]
        rows.append((case, latency, least * 1e3, least / spacing[case], float(np.mean(ends)) * 1e3))
    heads = ("change", "latency s", "least clearance mm", "in spacings", "RMS lₑ at the end mm")
    return Table(
        "switching", "Least distance of any two robots over all seeds; RMS of lₑ in the last 5 s", heads, tuple(rows)
    )


def verdict(found: Mapping[tuple[str, float], Sequence[Signals]], spacing: Mapping[str, float]) -> Verdict:
    """What this project claims of `nash` with changes of shape."""
    least = {key: min(clearance(trial.poses) for trial in trials) / spacing[key[0]] for key, trials in found.items()}
    worst = min(least, key=least.__getitem__)
    return Verdict(
        f"This project: while the shape changes no two robots come closer than {CLEAR:g} of the spacing, with plans "
        "on time and up to 0.5 s late.",
        f"The least clearance is {shown(least[worst])} spacings ({worst[0]}, plans {worst[1]:g} s late), over "
        f"{len(found[worst])} seeds.",
        grade([share >= CLEAR for share in least.values()]),
    )


CHAPTER = Chapter(_trials, _sections)
