"""Laws of telemetry: only valid messages are stored."""

from typing import Any

import numpy as np
import pytest

from dashboard.page import Page
from dashboard.telemetry.subscriber import TelemetrySubscriber
from formation.faults import Fault
from formation.link_ids import LinkId
from network import topics
from network.bus import Sample
from network.codec import encode, seal
from network.memory_bus import KeptInMemory
from tests.builders import motion, state, status
from tests.dashboard.fakes import bus, receive


@pytest.mark.parametrize(
    "changes",
    [
        {"stopped": [64]},
        {"live": [0]},
        {"waiting_for": [4]},
        {"dismissed": [4]},
        {"slots": np.zeros((2, 3))},
        {"faults": {"1->2": {"loss": "x"}}},
        {"faults": {"1->2": {"loss": 1.5}}},
        {"faults": {"1->2": {"cut": [[]]}}},
        {"faults": {"1->2": {"speed": 1.0}}},
    ],
)
def test_an_invalid_state_is_dropped(changes: dict[str, Any]) -> None:
    telemetry = TelemetrySubscriber(bus())
    assert receive(telemetry, topics.state("x"), encode(state()))
    assert not receive(telemetry, topics.state("x"), encode(state(stamp=2.0, **changes)))
    message = telemetry.snapshot().state
    assert message is not None
    assert message.stamp == 1.0


def test_faults_of_a_state_are_numbers_also_if_they_came_as_texts() -> None:
    telemetry = TelemetrySubscriber(bus())
    assert receive(telemetry, topics.state("x"), encode(state(faults={"1->2": {"loss": "30%", "latency": 0.1}})))
    message = telemetry.snapshot().state
    assert message is not None
    assert message.faults == {LinkId(1, 2): Fault(loss=0.3, latency=0.1)}


def test_an_invalid_status_is_counted_and_dropped() -> None:
    session = bus()
    telemetry = TelemetrySubscriber(session)
    good = status(1, 3, plan=motion(5))
    for sender, payload in (
        (1, encode(good)),
        (1, b"garbage"),
        (1, seal(b"whole, but no status")),
        (2, encode(good)),
    ):
        session.receive(Sample(topics.status("x", sender), payload))
    message = telemetry.snapshot().statuses
    assert list(message) == [1]
    assert message[1].plan is not None
    assert message[1].plan.begins == 0.05
    assert telemetry._rejects.count == 3


def test_the_last_status_of_an_agent_that_is_gone_is_dropped_also_if_it_comes_late(page: Page) -> None:
    telemetry = page._feed.source
    assert isinstance(telemetry, TelemetrySubscriber)
    waiting = telemetry._waiting
    assert isinstance(waiting, KeptInMemory)
    waiting.put(Sample(topics.status("x", 2), encode(status(2, 1))))
    assert list(telemetry.snapshot().statuses) == [2]
    assert receive(telemetry, topics.state("x"), encode(state(stamp=1.1, live=[1, 3])))
    waiting.put(Sample(topics.status("x", 2), encode(status(2, 1))))
    snapshot, links, *_ = page._feed.now()
    assert not snapshot.statuses
    assert [(view.label, view.lost) for view in links] == [("LOST", True), ("...", False), ("...", False)]
    assert receive(telemetry, topics.state("x"), encode(state(stamp=1.2)))
    assert not telemetry.snapshot().statuses, "for good"
