"""Laws of the recorder's process: whatever becomes of its file, the run does not notice."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from network import topics
from network.bus import Presence
from network.codec import encode
from network.memory_bus import MemoryBus, MemoryHub
from records import process
from records.file import RecordFile
from records.record import load
from tests.records.recorded import scenario
from world.journal import Journal
from world.world import World

RUN = "memory"


class Turns:
    """A lifetime of so many looks; at each, the world may do something."""

    def __init__(self, looks: int, act: Callable[[], object]) -> None:
        self.looks, self._act = looks, act

    @property
    def over(self) -> bool:
        self.looks -= 1
        self._act()
        return self.looks < 0


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> tuple[MemoryBus, MemoryBus, Callable[[], None]]:
    """Buses of world and recorder, and what makes the world go on for a tick."""
    monkeypatch.setattr(process, "FLUSH_SECONDS", 0.0)
    monkeypatch.setattr(process, "LOOK_SECONDS", 0.0)
    hub = MemoryHub(lambda letter: (0.0,))
    ours, theirs = hub.join(RUN, "world"), hub.join(RUN, "recorder")
    simulated = World(scenario())
    journal = Journal(simulated, wanted=True)
    ours.announce(topics.stretch(RUN), reliable=True)
    ours.watch()

    def tick() -> None:
        simulated.advance({})
        journal.note(simulated.robots)
        stretch = journal.take()
        if stretch is not None:
            assert encode(stretch)
            ours.publish(topics.stretch(RUN), stretch)

    return ours, theirs, tick


def seen(bus: MemoryBus) -> list[bool]:
    return [item.here for item in bus.arrivals() if isinstance(item, Presence) and item.role == "recorder"]


def test_a_recorder_writes_what_it_hears_and_closes_the_file(world: Any, tmp_path: Path) -> None:
    ours, theirs, tick = world
    assert process.run(theirs, tmp_path / "run.mcap", Turns(60, tick), detail="default")  # type: ignore[arg-type]
    read = load(tmp_path / "run.mcap")
    assert read.sound
    assert len(read.episodes[0].ticks) > 50
    assert seen(ours) == [True]


def test_a_full_disk_ends_the_record_and_nothing_else(
    world: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    ours, theirs, tick = world
    flushes = 0
    flush = RecordFile.flush

    def full(self: RecordFile) -> None:
        nonlocal flushes
        flushes += 1
        if flushes > 30:
            raise OSError(28, "No space left on device")
        flush(self)

    monkeypatch.setattr(RecordFile, "flush", full)
    turns = Turns(80, tick)
    assert not process.run(theirs, tmp_path / "run.mcap", turns, detail="default")  # type: ignore[arg-type]
    assert turns.looks < 0, "it waits for its end, so that nobody starts it again"
    assert seen(ours) == [True, False]
    assert "No space left" in caplog.text
    assert len(load(tmp_path / "run.mcap").episodes[0].ticks) > 20


def test_a_file_that_cannot_be_made_does_not_end_the_process(world: Any, tmp_path: Path) -> None:
    ours, theirs, tick = world
    turns = Turns(5, tick)
    assert not process.run(theirs, tmp_path / "missing" / "run.mcap", turns, detail="default")  # type: ignore[arg-type]
    assert turns.looks < 0
    assert seen(ours) == []


def test_a_recorder_never_writes_over_a_record(world: Any, tmp_path: Path) -> None:
    for name in ("run.mcap", "run-2.mcap"):
        (tmp_path / name).write_bytes(b"kept")
    with process.new_file(tmp_path / "run.mcap") as file:
        assert file.path == tmp_path / "run-3.mcap"
    assert (tmp_path / "run.mcap").read_bytes() == b"kept"
