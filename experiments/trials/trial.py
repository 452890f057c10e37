"""Many flights on several cores: what is flown, what is kept of it, and the pool that flies it."""

import multiprocessing
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from formation.arrays import FloatArray
from formation.scenario import files
from formation.scenario.scenario import Scenario

Job = TypeVar("Job")
Done = TypeVar("Done")
GAP_EVERY = 10
"""Ticks from one sample of the Nash gap to the next: 10 Hz at the paper's control interval."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One flight to be flown."""

    key: str
    """What the report calls it; unique."""
    scenario: str
    """Name of a shipped scenario, or a TOML file."""
    settings: tuple[str, ...] = ()
    """Changes to it, `key=value`."""
    in_formation: bool = False
    """Start in formation, whatever start poses the scenario has."""
    gap: bool = False
    """Sample the Nash gap along the flight."""
    limit: float | None = None
    """Where the flight is cut if it is longer [s]."""

    def load(self) -> Scenario:
        """The scenario that is flown. Raises ScenarioError."""
        raw = files.read(self.scenario)
        if self.in_formation:
            raw.get("robots", {}).pop("poses", None)
        made = files.parse(raw, self.settings, where=self.key)
        if self.limit is None or made.duration <= self.limit:
            return made
        return files.parse(raw, (*self.settings, f"duration={self.limit!r}"), where=self.key)


@dataclass(frozen=True, slots=True, eq=False)
class TrialResult:
    """What is kept of a flight; T ticks, n robots."""

    key: str
    times: FloatArray
    """(T + 1,) [s]."""
    poses: FloatArray
    """(T + 1, n, 3) [m, m, rad]."""
    inputs: FloatArray
    """(T, n, 2) [m/s, rad/s]."""
    centre: FloatArray
    """(T + 1, 2) the reference p_r, where the formation's centre should be [m]."""
    distance: FloatArray
    """(T + 1, n) l_e [m]."""
    angle: FloatArray
    """(T + 1, n) psi_e [rad]."""
    tracking: FloatArray
    """(T + 1,) distance of the robots' mean position to p_r [m]."""
    gaps: FloatArray
    """(G, n) Nash gap; G = 0 unless it was ordered."""

    def after(self, start: float, stop: float = np.inf) -> slice:
        """Rows of `times` from `start` to `stop` [s]; of a flight cut before `start`, the last row."""
        first, last = np.searchsorted(self.times, (start - 1e-9, stop + 1e-9)).tolist()
        first = min(first, len(self.times) - 1)
        return slice(first, max(last, first + 1))


def simulate(order: Trial) -> TrialResult:
    """Fly one order, in this process. Raises ScenarioError."""
    from runtime.inprocess import Simulation  # noqa: PLC0415  loads the kernels: only who flies needs them

    task = order.load()
    flight = Simulation(task)
    gaps = []
    while not flight.finished:
        k = flight.world.k
        flight.step()
        if order.gap and k % GAP_EVERY == 0:
            stamp = k * task.control_interval
            gaps.append([agent.status(k, stamp).gap for _, agent in sorted(flight.agents.items())])
    trace = flight.trace
    distance, angle, tracking = trace.errors()
    return TrialResult(
        order.key,
        trace.times,
        trace.poses,
        trace.inputs,
        task.reference().centre(trace.times),
        distance,
        angle,
        tracking,
        np.array(gaps).reshape(-1, task.size),
    )


class WorkerPool:
    """Processes that work for this one; with a single worker, this process itself."""

    def __init__(self, workers: int | None = None) -> None:
        """A crew that has not begun.

        Args:
            workers: how many; by default one for each core that this process may use.
        """
        workers = workers or len(os.sched_getaffinity(0))
        # Forking is no choice: a progress bar has a thread.
        spawn = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(workers, mp_context=spawn) if workers > 1 else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool:
            self._pool.shutdown(cancel_futures=True)

    def map(
        self, work: Callable[[Job], Done], jobs: Iterable[Job], progress: Callable[[int, int], None] = lambda *_: None
    ) -> list[Done]:
        """What `work` makes of each job, in their order; it does not depend on the number of workers.

        Args:
            work: a function that other processes can import.
            jobs: what it is called with.
            progress: called with the number of jobs that are done, and of all.
        """
        jobs = list(jobs)
        progress(0, len(jobs))
        if self._pool is None:
            return [_told(work(job), progress, done + 1, len(jobs)) for done, job in enumerate(jobs)]
        futures = [self._pool.submit(work, job) for job in jobs]
        for done, future in enumerate(as_completed(futures)):
            _told(future.result(), progress, done + 1, len(jobs))
        return [future.result() for future in futures]


def _told(result: Done, progress: Callable[[int, int], None], done: int, of: int) -> Done:
    progress(done, of)
    return result


def simulate_all(
    orders: Sequence[Trial], crew: WorkerPool, progress: Callable[[int, int], None] = lambda *_: None
) -> dict[str, TrialResult]:
    """Fly every order.

    Args:
        orders: with keys that differ.
        crew: who flies.
        progress: called with the number of flights that are done, and of all.

    Returns:
        What was flown, by key.

    Raises:
        ScenarioError: an order cannot be flown; nothing has then been flown.
    """
    if len({order.key for order in orders}) != len(orders):
        raise ValueError("two orders have the same key")
    for order in orders:
        order.load()
    return {flown.key: flown for flown in crew.map(simulate, orders, progress)}
