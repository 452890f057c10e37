"""Laws of a run without keys: one false message of a kind does no lasting harm, whoever it claims to be from."""

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formation.errors import WireError
from network import topics
from network.bus import Query, Sample
from network.codec import decode, encode
from network.control import SetFault
from network.messages import Command, Plan, State, Status, Tick
from network.zenoh_bus import ZenohBus
from tests.processes.live import Up

pytestmark = pytest.mark.processes
FAR = 10**6
WHOLE, WHOLE_SECONDS = 0.005, 5.0
"""Largest distance error of a formation that is whole [m], and time for that [s]."""
FALSE = 10**12
"""`seq` of false states, by which the test knows them."""


class Stranger:
    """Somebody at the socket of a run: hears all, and says it again, changed."""

    def __init__(self, runs: Path) -> None:
        self.endpoint = f"unixsock-stream/{runs}/test/router.sock"
        self.bus = ZenohBus(self.endpoint, "test")
        self.bus.subscribe("echelon/test/**")
        self.newest: dict[str, Any] = {}
        self.look(1.0)

    def look(self, seconds: float) -> None:
        """Take in what is said for so long [s]."""
        for item in self.bus.incoming(seconds):
            topic = topics.topic_of(item.key) if isinstance(item, Sample) else None
            if isinstance(item, Sample) and topic is not None and topic.published:
                with contextlib.suppress(WireError):
                    message = decode(topic.messages[0], item.payload)
                    if getattr(message, "seq", 0) < FALSE:
                        self.newest[item.key] = message

    def true(self, key: str) -> Any:
        return self.newest[key]

    def say(self, key: str, message: Any) -> None:
        self.bus.announce(key, reliable=True)
        self.bus.publish(key, message)

    @property
    def state(self) -> State:
        found: State = self.newest[topics.state("test")]
        return found

    def seconds_until_whole(self) -> float:
        """How long it takes until time passes, every agent takes part and the formation is whole [s]."""
        begun = time.monotonic()
        self.look(0.1)  # what was said while the test did something else is no sign of life now
        before = self.state
        while time.monotonic() - begun < 2.0 * WHOLE_SECONDS:
            self.look(0.1)
            state = self.state
            going = (state.episode, state.stamp) > (before.episode, before.stamp + 0.2)
            whole = going and state.live == [1, 2, 3] and state.status == "running"
            if whole and np.abs(state.distance_errors).max() < WHOLE:
                break
        return time.monotonic() - begun


def false_ticks(stranger: Stranger) -> Iterator[tuple[str, Any]]:
    key = topics.tick("test")
    tick: Tick = stranger.true(key)
    moved = tick.poses + np.array([1.0, 1.0, 1.0]) if len(tick.poses) else tick.poses
    interval = tick.stamp / tick.seq
    yield key, replace(tick, seq=tick.seq + 3, stamp=interval * (tick.seq + 3), poses=moved)
    yield key, replace(tick, seq=tick.seq + FAR, stamp=interval * (tick.seq + FAR), poses=moved)
    yield key, replace(tick, episode=tick.episode + 1)
    yield key, replace(tick, revision=tick.revision + 7, seq=tick.seq + 1, stamp=interval * (tick.seq + 1))
    yield key, replace(tick, gone=[1, 2, 3], last=True)


def false_plans(stranger: Stranger) -> Iterator[tuple[str, Any]]:
    for robot in (1, 2, 3):
        key = topics.plan("test", robot)
        plan: Plan = stranger.true(key)
        wrong: dict[str, Any] = {"pose": plan.pose + 5.0, "lag": 1e3, "lag_rate": 1.0, "waits": True, "number": 2**62}
        for ahead in (1, 5, FAR):
            yield key, replace(plan, seq=plan.seq + ahead, stamp=plan.stamp + 0.01 * ahead, **wrong)
        yield key, replace(plan, episode=plan.episode + 1, **wrong)


def false_commands(stranger: Stranger) -> Iterator[tuple[str, Any]]:
    for robot in (1, 2, 3):
        key = topics.command("test", robot)
        command: Command = stranger.true(key)
        for ahead in (1, 5, FAR):
            yield key, replace(command, seq=command.seq + ahead, v=1e15, omega=-1e15, failure="forged")


def false_statuses_and_states(stranger: Stranger) -> Iterator[tuple[str, Any]]:
    status: Status = stranger.true(topics.status("test", 1))
    yield topics.status("test", 1), replace(status, seq=status.seq + FAR, age=1e15, missed=2**62)
    state = stranger.state
    lies: tuple[dict[str, Any], ...] = (
        {"status": "finished"},
        {"dismissed": [1, 2, 3]},
        {"waiting_for": list(range(1, 65))},
    )
    for wrong in lies:
        yield topics.state("test"), replace(state, seq=FALSE, **wrong)


FORGERIES = (false_ticks, false_plans, false_commands, false_statuses_and_states)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_false_message_of_any_kind_does_no_lasting_harm(up: Callable[..., Up], runs: Path, mode: str) -> None:
    run = up("--no-dashboard", *(["--realtime"] if mode == "realtime" else []))
    run.running()
    stranger = Stranger(runs)
    stranger.seconds_until_whole()
    took: dict[str, float] = {}
    for forge in FORGERIES:
        for key, message in list(forge(stranger)):
            stranger.say(key, message)
            stranger.look(0.02)
        took[forge.__name__] = stranger.seconds_until_whole()
    took["answers"] = _answer_falsely(stranger)
    for role, number in (("world", 0), ("launcher", 0), ("agent", 1), ("agent", 77), ("recorder", 0)):
        with ZenohBus(stranger.endpoint, "test") as other:
            other.appear(role, number)
            stranger.look(0.2)
        took[f"token of {role} {number}"] = stranger.seconds_until_whole()
    stranger.bus.close()
    assert {what: seconds for what, seconds in took.items() if seconds > WHOLE_SECONDS} == {}
    assert run.process.poll() is None
    assert "Traceback" not in run.text()
    assert run.end() == 0


def _answer_falsely(stranger: Stranger) -> float:
    """Pass for the world while agents ask for the Setup, then go; how long it takes until the run is whole [s]."""
    bus = stranger.bus
    setup = bus.setup()
    assert setup is not None
    false = replace(setup, revision=setup.revision + FAR, stamp=setup.stamp + 1e6, episode=setup.episode)
    with ZenohBus(stranger.endpoint, "test") as other:
        other.serve(topics.question("test"))
        time.sleep(0.2)
        reply = bus.ask(SetFault(link="1->2", changes={"latency": 0.01}))  # for its revision every agent asks now
        assert reply is not None
        assert reply.ok
        answered = 0
        for item in other.incoming(1.5):
            if isinstance(item, Query):
                item.answer(encode(false))
                answered += 1
    assert answered >= 3
    return stranger.seconds_until_whole()
