"""A world, a session and exported data, as a test needs them."""

from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

from dashboard.telemetry.export_buffer import ExportBuffer, ExportData
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.subscriber import TelemetrySubscriber
from formation.scenario.files import load
from network.control import Operation
from network.messages import Reply, Setup, State
from network.zenoh_bus import Incoming, Sample, Wake


class FakeWorld:
    """Replies always the same, and keeps what was requested."""

    def __init__(self, reply: Reply | None, *, connected: bool = True) -> None:
        self.reply, self.connected, self.asked = reply, connected, list[Operation]()

    def ask(self, operation: Operation) -> Reply | None:
        self.asked.append(operation)
        return self.reply


class FakeTelemetry:
    """Never has another scenario."""

    def update_scenario(self) -> None:
        pass


class FakeSession:
    """A session whose incoming messages a test chooses."""

    run, connected = "x", True

    def __init__(self) -> None:
        self.inbox: SimpleQueue[Incoming] = SimpleQueue()
        self.kept: dict[str, list[Sample]] = {}

    def keep(self, key: str, depth: int) -> Any:
        waiting = self.kept.setdefault(key, [])
        return SimpleNamespace(kept=waiting, take=lambda: iter([waiting.pop(0) for _ in list(waiting)]))

    def subscribe(self, key: str) -> None:
        pass

    def watch(self) -> None:
        pass

    def appear(self, role: str) -> None:
        pass

    def wake(self) -> None:
        self.inbox.put(Wake())

    def setup(self) -> Setup:
        return Setup(0, 0, 0.0, 0, 0, load("triangle-circle").model_dump_json(), "lockstep", {})


def receive(telemetry: TelemetrySubscriber, key: str, payload: bytes) -> bool:
    """Give it a payload; returns whether it was stored, not rejected."""
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
