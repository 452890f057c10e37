"""Episodes in this process: at once, or tick by tick."""

import os
from collections.abc import Callable, Mapping
from time import perf_counter
from typing import Any, Self

from agents.controllers.interface import Observation
from api.arguments import plain, whole
from api.copying import copied, dumped, loaded
from api.intervening import Intervening
from api.result import Result
from api.scenarios import load, table_of, tell
from formation.errors import EchelonError
from formation.link_ids import LinkId
from formation.scenario.scenario import Scenario
from formation.schema import time_of
from network.control import Operation
from network.messages import State
from runtime.inprocess import Simulation as Engine
from runtime.precompile import ensure_compiled

PROGRESS_TICKS = 50


class Simulation(Intervening):
    """An episode, tick by tick, with faults and observations from outside.

    A copy (`copy.deepcopy`, `copy.copy`, `pickle`) goes on by itself, to the same bits.

    Example:
        >>> import echelon
        >>> simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 3}))
        >>> simulation.step(100)
        >>> simulation.set_fault("1->2", cut=True)
        >>> simulation.step(100)
        >>> round(simulation.time, 2), round(simulation.observation(2).upstream.age, 2)
        (2.0, 1.01)
        >>> while not simulation.finished:
        ...     simulation.step()
        >>> simulation.result().poses.shape
        (301, 3, 3)
    """

    def __init__(self, scenario: str | os.PathLike[str] | Scenario = "triangle-circle") -> None:
        """The episode at t = 0.

        Args:
            scenario: of `load`, or what it takes.

        Raises:
            ScenarioError: it is wrong.
        """
        ensure_compiled(tell)
        self.scenario = scenario if isinstance(scenario, Scenario) else load(scenario)
        """What is simulated."""
        self._engine = Engine(self.scenario)
        self._began = perf_counter()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._engine.world.now

    @property
    def finished(self) -> bool:
        """Whether the scenario's duration is over."""
        return self._engine.finished

    @property
    def state(self) -> State:
        """Poses, slots, errors, faults and events of now, as a live run publishes them."""
        world = self._engine.world
        return world.state(seq=world.k, status="finished" if self.finished else "running")

    def step(self, ticks: int = 1) -> None:
        """Simulate so many ticks, or to the end. Raises EchelonError: it is no number of ticks."""
        for _ in range(whole("ticks", ticks, 0)):
            if self.finished:
                return
            self._engine.step()

    def observation(self, robot: int) -> Observation:
        """What the robot's controller was asked with last.

        Raises:
            EchelonError: there is no such robot, or it has not planned yet.
        """
        agent = self._engine.agents.get(whole("robot", robot, 1))
        if agent is None:
            raise EchelonError(f"robot: expected 1 to {self.scenario.size}; got {robot}")
        if agent.observation is None:
            raise EchelonError(f"robot {robot}: expected a step before its first observation; got none")
        return agent.observation

    def set_fault(self, link: str | LinkId = "all", *, until: float | str | None = None, **changes: Any) -> None:
        """Set keys of a link's fault from the next tick on.

        Args:
            link: such as "1->2" or "world->1"; "all" for every one between robots.
            until: simulated time at which it ends [s], or text such as "2s"; if None, it stays.
            changes: keys of [link], such as latency, loss, cut.

        Raises:
            FaultError: there is no such link or key, or the end is not later than now.
        """
        self._engine.world.change_fault(str(link), plain(changes), plain(until))

    def clear_faults(self, link: str | LinkId = "all") -> None:
        """Remove what was set on a link from the next tick on. Raises FaultError."""
        self._engine.world.clear_faults(str(link))

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """Another that goes on from here, with the same scenario. Raises EchelonError: a part cannot be copied."""
        memo[id(self)] = other = type(self).__new__(type(self))
        memo[id(self.scenario)] = self.scenario
        vars(other).update(copied(vars(self), memo))
        return other

    def __reduce__(self) -> tuple[Any, ...]:
        """As bytes, for pickle. Raises EchelonError: a part cannot be pickled."""
        taken = perf_counter() - self._began
        return _unpickled, (type(self), dumped({**vars(self), "_began": taken}))

    def _intervene(self, operation: Operation) -> None:
        self._engine.world.intervene(operation)

    def result(self, *, warmup: float = 0.0) -> Result:
        """What has come of it so far; measures start at `warmup` [s]. Raises EchelonError: that is no time."""
        warmup = time_of("warmup", warmup)
        trace = self._engine.trace
        summary = self._engine.world.summary(warmup=warmup)
        more = {"engine": "inprocess", "wall_s": perf_counter() - self._began}
        return Result(self.scenario, trace.poses, trace.inputs, trace.ages, trace.measured(), {**summary, **more})


def _unpickled(kind: type[Simulation], data: bytes) -> Simulation:
    """The simulation that `Simulation.__reduce__` made bytes of. Raises EchelonError: a class is missing here."""
    found = kind.__new__(kind)
    vars(found).update(loaded(data))
    found._began = perf_counter() - found._began
    return found


def simulate(
    scenario: str | os.PathLike[str] | Scenario = "triangle-circle",
    overrides: Mapping[str, Any] | None = None,
    *,
    seed: int | None = None,
    warmup: float = 0.0,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Simulate a scenario to its end in this process: bit for bit what the processes of a run do.

    Args:
        scenario: of `load`, or what it takes.
        overrides: what differs from it, as nested data.
        seed: of noise and faults, instead of the scenario's.
        warmup: measures of the summary start at this simulated time [s].
        progress: called now and then with the simulated time [s].

    Raises:
        EchelonError: the scenario is wrong, or warmup is no time.

    Example:
        >>> import echelon
        >>> result = echelon.simulate("triangle-circle", {"duration": 2, "noise": {"slip": 0.1}}, seed=3)
        >>> result.summary()["seed"], len(result.times)
        (3, 201)
    """
    warmup = time_of("warmup", warmup)
    changes = {**table_of(overrides), **({} if seed is None else {"seed": seed})}
    as_it_is = isinstance(scenario, Scenario) and not changes
    simulation = Simulation(scenario if as_it_is else load(scenario, changes))
    while not simulation.finished:
        simulation.step(PROGRESS_TICKS)
        if progress:
            progress(simulation.time)
    return simulation.result(warmup=warmup)
