"""The page of errata: what is printed, what it must be, what shows it, and what it does to a flight."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from experiments.errata.entry import Entry
from experiments.errata.errata_list import ENTRIES
from formation.scenario.files import load
from runtime.inprocess import simulate

FLIGHTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "figure8": ("figure8", ("controller.name=paper", "duration=30")),
    "circle": ("circle", ("controller.name=paper", "duration=30")),
    "spiral": ("spiral", ("controller.name=paper", "duration=30")),
    "triangle-corner": ("triangle-corner", ("controller.name=paper", "duration=25", "path.at=10")),
    "figure8, leader-follower": ("figure8", ("controller.name=leader_follower", "duration=60")),
    "circle, leader-follower": ("circle", ("controller.name=leader_follower", "duration=60")),
}
"""Flights by name: the scenario and its settings. Everything else is as printed."""

Job = tuple[str, tuple[str, ...]]
"""A flight and settings on top of its own."""
Mapper = Callable[[Callable[[Job], float], Iterable[Job]], Iterable[float]]


@dataclass(frozen=True, slots=True)
class Erratum:
    """One row of the page."""

    number: int
    where: str
    """Equation, table or test of the paper."""
    printed: str
    mended: str
    evidence: str
    """What shows it, with the figures computed for it, and the test that holds it."""
    effect_mm: dict[str, tuple[float, float]] | None
    """By flight: RMS l_e as printed, and with only this one mended [mm]; None if no controller feels it."""
    note: str


def errata_table(progress: Callable[[float], None] | None = None, *, mapper: Mapper = map) -> tuple[Erratum, ...]:
    """Every erratum, computed and flown.

    Args:
        progress: told the share that is done.
        mapper: how flights are flown: `map`, or that of a pool of processes.
    """
    jobs = list(dict.fromkeys(job for entry in ENTRIES for pair in _jobs(entry).values() for job in pair))
    rms: dict[Job, float] = {}
    for job, value in zip(jobs, mapper(rms_mm, jobs), strict=True):
        rms[job] = value
        if progress:
            progress(len(rms) / len(jobs))
    return tuple(
        Erratum(
            entry.number,
            entry.where,
            entry.printed,
            entry.mended,
            f"{entry.shows.format(*entry.figures())} (test_{entry.test})",
            {flight: (rms[printed], rms[mended]) for flight, (printed, mended) in _jobs(entry).items()} or None,
            entry.note,
        )
        for entry in ENTRIES
    )


def _jobs(entry: Entry) -> dict[str, tuple[Job, Job]]:
    """By flight: the jobs as printed and as mended."""
    return {flight: ((flight, entry.as_printed), (flight, entry.as_mended)) for flight in entry.flights}


def rms_mm(job: Job) -> float:
    """RMS l_e of the worst robot on a flight with these settings [mm]."""
    name, settings = FLIGHTS[job[0]]
    robots = simulate(load(name, [*settings, *job[1]]))["robots"]
    return 1e3 * max(float(robot["distance_error_m"]["rms"]) for robot in robots.values())
