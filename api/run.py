"""A run of processes from Python: a world, an agent a robot, and a page."""

import atexit
import itertools
import json
import os
import socket
import threading
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Self

import numpy as np

from api.intervening import Intervening, order
from api.result import Result
from api.scenarios import load, tell
from formation.arrays import FloatArray
from formation.errors import EchelonError
from formation.link_ids import LinkId
from formation.scenario.files import parse
from formation.scenario.scenario import Scenario
from formation.schema import time_of
from network import control
from network.control import Operation
from network.messages import State
from network.requests import Setup, TraceRows
from network.zenoh_bus import ZenohBus
from runtime.launcher import LiveRun
from runtime.own_code import check_main
from runtime.run_registry import free_name
from world.measures.trace import Errors

LOOPBACK = "127.0.0.1"
ANSWER_SECONDS = 10.0
START_SECONDS = 60.0
"""Longest wait for the world's first state [s]."""
TRIES = 3
"""For a result of one episode, if others begin while it is fetched."""


class Run(Intervening):
    """A live run. Use it as a context manager: leaving it ends its processes."""

    def __init__(self, live: LiveRun, scenario: Scenario, name: str) -> None:
        """Of `launch`; the processes are there already."""
        self.scenario, self.name = scenario, name
        self.page = live.page
        """Address of its page; empty without one."""
        self.endpoint = live.endpoint
        """Where its router listens: for a plain Zenoh client in mode "client"; the manual has its messages."""
        self._live, self._session = live, ZenohBus(live.endpoint, name)
        self._changed = threading.Condition()
        self._over, self._error = False, ""
        self._thread = threading.Thread(target=self._watch, name=f"run {name}", daemon=True)
        self._thread.start()
        atexit.register(self.close)
        try:
            self._begin()
        except BaseException:
            self.close()
            raise

    def _begin(self) -> None:
        """Wait for the world: it answers from its first state on."""
        with self._changed:
            if not self._changed.wait_for(lambda: self.state is not None or self._error, START_SECONDS) or self._error:
                reason = self._error or f"it is silent for {START_SECONDS:g} s"
                raise EchelonError(f"run {self.name}: expected its world to begin; {reason}")

    @property
    def _bus(self) -> ZenohBus:
        """What the run is asked over. Raises EchelonError: it is over."""
        if self._over:
            raise EchelonError(f"run {self.name}: expected to be asked within its with block; it is over")
        return self._session

    def _watch(self) -> None:
        try:
            while not self._over and self._live.watch():
                with self._changed:
                    self._changed.notify_all()
            reason = "" if self._over else "it was stopped"
        except EchelonError as error:
            reason = str(error)
        with self._changed:
            self._error = reason or "it was closed"
            self._changed.notify_all()

    @property
    def state(self) -> State | None:
        """The newest state that its world has published; None before the first."""
        return self._live.state

    @property
    def time(self) -> float:
        """Simulated time of that state [s]."""
        state = self.state
        return state.stamp if state else 0.0

    def wait(self, until: float | None = None) -> None:
        """Wait until a simulated time [s], or for the end of the scenario.

        Raises:
            EchelonError: the run ends before, or that is no time.
        """
        duration = self.scenario.duration
        until = None if until is None else time_of("until", until)
        if until is not None and until > duration + 1e-9:
            raise EchelonError(f"until: expected at most the duration of {duration:g} s; got {until:g}")
        with self._changed:
            while True:
                state = self.state
                if state and (state.status == "finished" or (until is not None and state.stamp >= until)):
                    return
                if self._error:
                    raise EchelonError(f"run {self.name}: expected to reach {until or duration:g} s; {self._error}")
                self._changed.wait(1.0)

    def set_fault(self, link: str | LinkId = "all", *, seconds: float | str | None = None, **changes: Any) -> None:
        """Set keys of a link's fault from the next tick on.

        Args:
            link: such as "1->2" or "world->1"; "all" for every one between robots.
            seconds: for how long [s], or text such as "2s"; until further notice, if None.
            changes: keys of [link], such as latency, loss, cut.

        Raises:
            EchelonError: there is no such link or key, or a value is out of range.
        """
        self._ask(order("fault", {"link": str(link), "changes": changes, "seconds": seconds}))

    def clear_faults(self, link: str | LinkId = "all") -> None:
        """Remove what was set on a link. Raises EchelonError."""
        self._ask(control.Clear(link=str(link)))

    def drive(self, v: float, omega: float, *, seconds: float | str | None = None) -> None:
        """Order a formation whose path is `driven` a speed [m/s] and a turn rate [rad/s] from the next tick on.

        Args:
            v: of the centre; below 0 backwards.
            omega: of the centre, counter-clockwise positive.
            seconds: simulated time after which it slows to a stop; None: until the next order.

        Raises:
            EchelonError: the path is of another kind, or a number is out of range.
        """
        self._ask(order("drive", {"v": v, "omega": omega, "seconds": seconds}))

    def go_to(self, x: float, y: float) -> None:
        """Drive the centre of such a formation to a point [m], and stop there. Raises EchelonError."""
        self._ask(order("goto", {"x": x, "y": y}))

    def start(self) -> None:
        """Start, or continue."""
        self._ask(control.Start())

    def pause(self) -> None:
        """Stop simulated time."""
        self._ask(control.Pause())

    def result(self, *, warmup: float = 0.0) -> Result:
        """What has come of the episode so far; measures start at `warmup` [s]. Raises EchelonError."""
        warmup = time_of("warmup", warmup)
        for _ in range(TRIES):
            setup = self._setup()
            summary = {**self._ask(control.GetSummary(warmup=warmup)), "engine": "processes"}
            arrays = self._rows(setup.episode, summary.get("ticks", 0))
            if arrays:
                errors = Errors(*(arrays.pop(name) for name in Errors._fields))
                return Result(self._scenario_of(setup), errors=errors, summary=summary, **arrays)
        raise EchelonError(
            f"run {self.name}: expected an episode that goes on; a new one began {TRIES} times meanwhile"
        )

    def _rows(self, episode: int, ticks: int) -> dict[str, FloatArray]:
        """The trace of an episode up to a tick: arrays by name, none if another has begun. Raises EchelonError."""
        parts: list[dict[str, FloatArray]] = []
        last = 0
        while not parts or last < ticks:
            rows = TraceRows.of(self._ask(control.GetTrace(first=last)))
            if rows.episode != episode or rows.ticks < ticks:
                return {}
            parts.append(rows.arrays(last))
            last = rows.last
        whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        return {name: values[: ticks + (name not in ("inputs", "ages"))] for name, values in whole.items()}

    def _setup(self) -> Setup:
        setup = self._bus.setup(timeout=ANSWER_SECONDS)
        if setup is None:
            raise self._silent()
        return setup

    def _scenario_of(self, setup: Setup) -> Scenario:
        """What the run simulates now: its page may have chosen another scenario."""
        if setup.scenario == self.scenario.model_dump_json(exclude_unset=True):
            return self.scenario
        return parse(json.loads(setup.scenario), where=f"run {self.name}")

    def _intervene(self, operation: Operation) -> None:
        self._ask(operation)

    def _ask(self, operation: Operation) -> dict[str, Any]:
        reply = self._bus.ask(operation, timeout=ANSWER_SECONDS)
        if reply is None:
            raise self._silent()
        if not reply.ok:
            raise EchelonError(reply.reason)
        return reply.value

    def _silent(self) -> EchelonError:
        return EchelonError(f"run {self.name}: expected its world to answer; {self._error or 'it does not'}")

    def close(self) -> None:
        """End its processes; nothing is left behind."""
        if self._over:
            return
        self._over = True
        self._thread.join()
        self._session.close()
        self._live.__exit__(None, None, None)
        atexit.unregister(self.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Run {self.name} of {self.scenario.name}, {self.page or 'no page'}>"


_numbers = itertools.count(1)


def launch(
    scenario: str | os.PathLike[str] | Scenario = "triangle-circle",
    overrides: Mapping[str, Any] | None = None,
    *,
    page: bool = True,
    realtime: bool = False,
    speed: float | None = None,
    paused: bool = False,
) -> Run:
    """Start a run of processes; in lockstep its trajectory is that of `simulate`, to the last bit.

    Args:
        scenario: of `load`, or what it takes.
        overrides: what differs from it, as nested data.
        page: whether it has a page.
        realtime: step by the wall clock, without waiting for slow agents.
        speed: simulated seconds per second, 0 as fast as possible; by default 1 with a page, else 0.
        paused: wait for `Run.start`.

    Raises:
        EchelonError: the scenario or the speed is wrong, or it cannot run as processes.

    Example:
        >>> import echelon
        >>> with echelon.launch("triangle-circle", {"duration": 2}, page=False, paused=True) as run:
        ...     run.set_fault("1->2", loss=0.5)
        ...     run.start()
        ...     run.wait()
        ...     result = run.result()
        >>> result.poses.shape
        (201, 3, 3)
    """
    check_main("launch")
    whole = scenario if isinstance(scenario, Scenario) and not overrides else load(scenario, overrides)
    name = free_name(f"{whole.name[:24]}-{os.getpid()}-{next(_numbers)}")
    if speed is None:
        speed = 0.0 if realtime is False and not page else 1.0
    speed = control.checked_speed(speed)
    live = LiveRun(
        name,
        whole,
        tell=tell,
        dashboard=(LOOPBACK, _free_port()) if page else None,
        realtime=realtime,
        speed=speed,
        paused=paused,
        ghost=page,
    )
    live.__enter__()
    return Run(live, whole, name)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])
