"""When talking pays: a few rows of the study of that name (docs/theory.md, sections 10 and 16)."""

from collections.abc import Mapping, Sequence

import numpy as np

from experiments.paper.chapters import Chapter, Extent
from experiments.report.report import Section, Verdict, grade
from experiments.report.table import Cell, Table
from experiments.study import study
from experiments.trials.result import Signals
from experiments.trials.trial import Trial
from formation.metrics import rms
from formation.scenario.overrides import merged

STUDY = "when-talking-pays"
ROWS = {
    "A": "noise only",
    "E": "robot 2 drives at most 0.03 m/s from 12 to 20 s",
    "G": "localisation by a camera, neighbours in sight",
    "H": "as G, and robot 2 not localised from 12 to 22 s",
}
"""Rows of the study that the report simulates, in words."""
NASH, SIGHT, SILENT = "nash", "sight only", "no messages"
SEEN = ("G", "H")
"""Rows in which robots see their upstream neighbour."""
WARMUP = 10.0
"""Measures start here [s]."""


def _cells() -> list[tuple[str, str, str]]:
    """Row, network and controller; one that uses no plan needs no network, and without sight two of them are one."""
    silent = [(row, "on time", name) for row in ROWS for name in (SIGHT, SILENT) if row in SEEN or name == SILENT]
    return [(row, network, NASH) for row in ROWS for network in ("on time", "late")] + silent


def _trials(extent: Extent) -> Sequence[Trial]:
    source = study.load(STUDY)
    axes = {axis.name: axis for axis in source.axes}
    found = []
    for row, network, controller in _cells():
        chosen = {"row": row, "network": network, "controller": controller}
        overrides = merged(source.overrides, *(axes[name].overrides(label) for name, label in chosen.items()))
        for seed in range(extent.seeds):
            name = _name(row, network, controller, seed)
            found.append(extent.trial(name, source.scenarios[0], overrides, seed=seed))
    return found


def _name(row: str, network: str, controller: str, seed: int) -> str:
    return f"talking/{row}/{network}/{controller}/{seed}"


def measure(trial: Signals) -> tuple[float, float]:
    """RMS over robots and ticks of l_e [mm], and of the commanded v's change from tick to tick [mm/s]."""
    rows = trial.after(WARMUP)
    changes = np.diff(trial.inputs[rows.start :, :, 0], axis=0)
    return rms(trial.distance[rows].ravel()) * 1e3, rms(changes.ravel()) * 1e3 if changes.size else 0.0


def _sections(extent: Extent, signals: Mapping[str, Signals]) -> Sequence[Section]:
    found = {
        cell: tuple(np.mean([measure(signals[_name(*cell, seed)]) for seed in range(extent.seeds)], axis=0).tolist())
        for cell in _cells()
    }
    return [
        Section(
            "when-talking-pays",
            "When talking pays",
            (
                "The same estimator, the same compensation and the same weight of the own slot for all: once with the "
                "neighbours' plans (`nash`), once with sight of the upstream neighbour alone, once with neither "
                "(`virtual_structure`). Slip, gyro and localisation noise in every row; measured from "
                f"{WARMUP:g} s on, means of {extent.seeds} seeds. Beside every error stands the jitter, for a "
                "smaller error can be bought with it.",
                table(found),
                verdict(found),
                f"All thirteen rows, three networks and six controllers, twenty seeds, with bands: `echelon study "
                f"{STUDY}` (it resumes where it was interrupted).",
            ),
        )
    ]


def table(found: Mapping[tuple[str, str, str], Sequence[float]]) -> Table:
    """A row of the table per row of the study; found is (RMS l_e, jitter) by row, network and controller."""
    columns = (("on time", NASH), ("late", NASH), ("on time", SIGHT), ("on time", SILENT))
    rows: list[tuple[Cell, ...]] = []
    for row, text in ROWS.items():
        cells: list[Cell] = [f"{row}: {text}"]
        for network, controller in columns:
            values = found.get((row, network, controller))
            cells += [None, None] if values is None else [values[0], values[1]]
        rows.append(tuple(cells))
    heads = ("nash", "nash, 0.3 s late", SIGHT, SILENT)
    return Table(
        "when-talking-pays",
        "RMS of lₑ over all robots in mm, and jitter of the commanded v in mm/s",
        ("row", *(f"{head}: {what}" for head in heads for what in ("lₑ", "jitter"))),
        tuple(rows),
    )


def verdict(found: Mapping[tuple[str, str, str], Sequence[float]]) -> Verdict:
    """What this project claims of messages in these rows."""

    def share(row: str, network: str, rival: str) -> float:
        return found[row, network, NASH][0] / found[row, "on time", rival][0]

    slow, late = share("E", "on time", SILENT), share("E", "late", SILENT)
    camera, blind = share("G", "on time", SIGHT), share("H", "on time", SIGHT)
    noise = share("A", "on time", SILENT)
    return Verdict(
        "This project: messages make the error twelve times smaller where a robot is slow (five times with plans "
        "0.3 s late), a tenth smaller than sight alone where robots localise badly, and 3 % smaller under noise alone.",
        f"The error is 1/{1.0 / slow:.0f} of that without messages where a robot is slow (late: 1/{1.0 / late:.1f}), "
        f"{camera:.0%} of sight alone in G and {blind:.0%} in H, and {noise:.0%} of no messages in A.",
        grade([slow <= 1.0 / 12.0, late <= 0.2, camera <= 0.9, noise <= 0.97]),
    )


CHAPTER = Chapter(_trials, _sections)
