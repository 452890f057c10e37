"""A world, a bus, a ghost and exported data, as a test needs them."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np

from dashboard.edits import Edit
from dashboard.page import Page
from dashboard.serving import server
from dashboard.serving.access import Guard
from dashboard.serving.server import serve
from dashboard.telemetry.export_buffer import ExportBuffer, ExportData
from dashboard.telemetry.feed import Source
from dashboard.telemetry.history import History
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.subscriber import TelemetrySubscriber
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network import topics
from network.bus import Incoming, Query, Sample
from network.codec import decode, encode
from network.control import Operation, operation
from network.memory_bus import MemoryBus, MemoryHub
from network.messages import Ghost, State
from network.requests import Reply, Request, Setup
from tests.builders import state


def world(reply: Reply | None) -> tuple[MemoryBus, list[Operation]]:
    """A bus on which a world replies so, or not at all; and the operations it was asked for."""
    hub, asked = MemoryHub(), list[Operation]()
    served = hub.join("x")
    served.serve(topics.control("x"))
    served.serve(topics.question("x"))

    def react(item: Incoming) -> None:
        assert isinstance(item, Query)
        asked.append(operation(decode(Request, item.payload)))
        if reply is not None:
            item.answer(encode(reply))

    served.react = react
    return hub.join("x"), asked


class FakeTelemetry:
    """Never has another scenario."""

    def update_scenario(self) -> None:
        pass


def edit(value: object, page: int = 1) -> Edit:
    """What a user does to a control."""
    client: Any = SimpleNamespace(client_id=page)
    return Edit(value, client)


def settle(page: Page) -> None:
    """Wait until what was written to controls is there."""

    async def nothing() -> None:
        pass

    asyncio.run_coroutine_threadsafe(nothing(), page._server.get_event_loop()).result(10.0)


@contextmanager
def page_of(scenario: Scenario) -> Iterator[Page]:
    """A page that nobody looks at, after its first frame, with what that wrote to controls."""
    served = serve(Guard("127.0.0.1"), 0, "x")
    made = Page(served, bus(scenario))
    assert receive(made._feed.source, topics.state("x"), encode(state(scenario.size)))
    made._feed.source.update_scenario()
    assert made._frame() == scenario.size
    settle(made)
    yield made
    server.stop(served)


def bus(scenario: Scenario | None = None) -> MemoryBus:
    """A bus on which a world replies with its setup; of a triangle, if none is given."""
    hub = MemoryHub()
    served = hub.join("x")
    served.serve(topics.control("x"))
    served.serve(topics.question("x"))
    setup = Setup(
        0, 0, 0.0, 0, 0, (scenario or load("triangle-circle")).model_dump_json(exclude_unset=True), "lockstep", {}
    )
    served.react = lambda item: item.answer(encode(setup)) if isinstance(item, Query) else None
    return hub.join("x")


def receive(telemetry: Source, key: str, payload: bytes) -> bool:
    """Give it a payload; returns whether it was stored, not rejected."""
    assert isinstance(telemetry, TelemetrySubscriber)
    before = telemetry._rejects.count
    telemetry._take(Sample(key, payload))
    return telemetry._rejects.count == before


def kept(*states: State) -> ExportData:
    """What the export buffer holds after these states."""
    export_buffer = ExportBuffer()
    for each in states:
        export_buffer.add(each, ring_links(each, {}), {})
    found = export_buffer.data()
    assert found is not None
    return found


def ghost(stamp: float, *, episode: int = 0, controller: str = "paper", error: float = 0.01) -> Ghost:
    """Robots that drive along x at 1 m/s and turn over the cut of the angle."""
    poses = np.stack([[stamp, float(i), (stamp + np.pi) % (2.0 * np.pi) - np.pi] for i in range(3)])
    return Ghost(0, 1, stamp, episode, controller, poses, np.full(3, error), np.zeros(3), error)


def beside(stamp: float, **changes: object) -> State:
    """The state while the ghost is asked for."""
    return state(stamp=stamp, compare="paper", **changes)  # type: ignore[arg-type]


def compared(live: float, other: float, seconds: float = 30.0) -> History:
    """A history of a run and a ghost with constant errors [m]."""
    history = History()
    for i in range(int(20 * seconds)):
        now = beside(0.05 * i, distance_errors=np.full(3, live), tracking_error=live)
        history.ghost.update(now, [ghost(0.05 * i, error=other)])
        history.add(now, [], {})
    return history
