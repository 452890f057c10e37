"""A run outlives its world: what users set is as it was, simulated time goes on, and a run that is paused stays so."""

import os
import random
import signal
from collections.abc import Callable, Mapping
from pathlib import Path
from time import sleep
from typing import Any, cast

import psutil
import pytest

from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.files import load
from network.control import Compare, GetOrders, Kill, Operation, Pause, SetFault, Speed, Start
from network.messages import State
from network.zenoh_bus import ZenohBus
from runtime import supervisor
from runtime.launcher import LiveRun
from tests.processes.live import compiled, runs, title, wait_for
from world.resume.saver import SECONDS

__all__ = ["compiled", "runs"]
KILLS, SEED = 10, 20
UNDER_WAY = 0.3
"""After so long a tick that was under way when the run was paused is over, and the state tells it [s]."""
ASKED: Mapping[int, tuple[Operation, Mapping[str, Any]]] = {
    0: (Speed(speed=2.0), {"speed": 2.0}),
    1: (SetFault(link="2->3", changes={"loss": 0.25}), {"faults": {LinkId(2, 3): Fault(loss=0.25)}}),
    3: (Compare(controller="consensus"), {"compare": "consensus"}),
    4: (Kill(robot=3), {"dismissed": [3], "waiting_for": [3]}),
    6: (Pause(), {"status": "paused"}),
    8: (Start(), {"status": "running"}),
}
"""What is asked before the kill of this number, and how it is seen from then on."""


class Watched:
    """A run, supervised whenever its newest state is looked at."""

    def __init__(self, live: LiveRun, session: ZenohBus) -> None:
        self._live, self._session = live, session

    def ask(self, operation: Operation) -> dict[str, Any]:
        reply = self.wait(lambda: self._session.ask(operation, timeout=1.0))
        assert reply.ok, reply.reason
        return dict(reply.value)

    def wait(self, what: Callable[[], Any]) -> Any:
        return wait_for(lambda: self._live.watch() and what(), seconds=15.0)

    def shows(self, wanted: Mapping[str, Any]) -> State | None:
        """The newest state, if this is so in it."""
        state = self._live.state
        return state if state and all(getattr(state, key) == value for key, value in wanted.items()) else None

    def until(self, wanted: Mapping[str, Any]) -> State:
        return cast("State", self.wait(lambda: self.shows(wanted)))

    def until_later(self, than: float) -> State:
        return cast("State", self.wait(lambda: (state := self._live.state) and state.stamp > than and state))

    def resumed(self, times: int) -> State:
        """The first state of a world that went on for this time."""
        return cast("State", self.wait(lambda: (state := self._live.state) and len(state.resumed) == times and state))


def world_of() -> int:
    """Process id of the run's world; it may have the environment of an earlier test, which started the fork server."""
    for process in psutil.Process().children(recursive=True):
        if "echelon test: world" in title(process):
            return int(process.pid)
    raise AssertionError("there is no world")


def test_a_world_that_is_killed_at_any_moment_loses_nothing_that_was_set(
    runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(supervisor, "DEATH_WINDOW", 0.0)  # or ten deaths would be too many
    draws = random.Random(SEED)
    settings: dict[str, Any] = {}
    lines: list[str] = []
    scenario = load("triangle-circle")
    with (
        LiveRun("test", scenario, tell=lines.append, endless=True) as live,
        ZenohBus(live.endpoint, "test") as session,
    ):
        run = Watched(live, session)
        run.until_later(0.5)
        for number in range(KILLS):
            operation, seen = ASKED.get(number, (GetOrders(), {}))
            run.ask(operation)
            settings.update(seen)
            before = run.until(settings)
            if before.status == "running":
                before = run.until_later(before.stamp + draws.uniform(0.0, 1.5))
            else:
                sleep(UNDER_WAY)
                before = run.until(settings)
            os.kill(world_of(), signal.SIGKILL)
            after = run.resumed(number + 1)
            assert run.shows(settings)
            assert after.live == before.live
            assert after.seq > before.seq
            assert after.events[-1].number > before.events[-1].number
            assert after.resumed[-1] * scenario.control_interval > before.stamp - SECONDS
            if before.status == "paused":
                assert after.stamp == before.stamp
            else:
                run.until_later(before.stamp)  # it goes on by itself
        orders = run.ask(GetOrders())
    assert len(orders["resumed"]) == KILLS
    assert len(orders["tables"]) == 2  # at the start, and when the fault was set
