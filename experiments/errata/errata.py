"""The page of errata: what is printed, what it must be, what shows it, and how it changes a formation's errors."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from experiments.errata.entry import Entry
from experiments.errata.errata_list import ENTRIES
from experiments.trials.trial import Measurement, Trial, trial
from formation.scenario.overrides import Overrides, merged

MEASURE = "distance_rms_m"
"""Of the worst robot."""


def _case(scenario: str, controller: str, duration: float, **more: Any) -> tuple[str, Overrides]:
    return scenario, {"controller": {"name": controller}, "duration": duration, **more}


CASES: dict[str, tuple[str, Overrides]] = {
    "figure8": _case("figure8", "paper", 30),
    "circle": _case("circle", "paper", 30),
    "spiral": _case("spiral", "paper", 30),
    "triangle-corner": _case("triangle-corner", "paper", 25, path={"at": 10}),
    "figure8, leader-follower": _case("figure8", "leader_follower", 60),
    "circle, leader-follower": _case("circle", "leader_follower", 60),
}
"""By name: the scenario and its overrides. Everything else is as printed."""


@dataclass(frozen=True, slots=True)
class Erratum:
    """One row of the page."""

    number: int
    where: str
    """Equation, table or test of the paper."""
    printed: str
    mended: str
    evidence: str
    """What shows it, with the numbers computed for it, and the test that holds it."""
    effect_mm: dict[str, tuple[float, float]] | None
    """By case: RMS l_e as printed, and with only this one mended [mm]; None if no controller is affected."""
    note: str


def trials() -> list[Trial]:
    """What has to be simulated for the table: each case as printed and as mended, once."""
    found = {trial.name: trial for entry in ENTRIES for pair in _pairs(entry).values() for trial in pair}
    return list(found.values())


def errata_table(rms_mm: Mapping[str, float]) -> tuple[Erratum, ...]:
    """Every erratum with its evidence and effect.

    Args:
        rms_mm: RMS l_e of the worst robot by the name of a trial of `trials()` [mm].
    """
    return tuple(
        Erratum(
            entry.number,
            entry.where,
            entry.printed,
            entry.mended,
            f"{entry.shows.format(*entry.numbers())} (test_{entry.test})",
            {case: (rms_mm[printed.name], rms_mm[mended.name]) for case, (printed, mended) in _pairs(entry).items()}
            or None,
            entry.note,
        )
        for entry in ENTRIES
    )


def _pairs(entry: Entry) -> dict[str, tuple[Trial, Trial]]:
    """By case: the trials as printed and as mended."""
    return {case: (_trial(case, entry.as_printed), _trial(case, entry.as_mended)) for case in entry.cases}


def _trial(case: str, changes: Overrides) -> Trial:
    scenario, overrides = CASES[case]
    name = f"errata/{case}/{dict(changes) or 'as printed'}"
    return trial(name, scenario, merged(overrides, changes), 0, Measurement((MEASURE,)))
