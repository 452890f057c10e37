"""Laws of the replay: a record is shown as its run was, whatever state the file is in."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from dashboard.telemetry.feed import Feed, View
from dashboard.telemetry.tape import Place
from formation.errors import EchelonError
from formation.link_ids import LinkId
from runtime.inprocess import Simulation
from runtime.replay.rows import rows
from runtime.replay.source import RecordSource
from tests.records.recorded import record, scenario


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Simulation]:
    path = tmp_path_factory.mktemp("replay") / "run.mcap"
    return path, record(path, scenario())


def loaded(*files: Path) -> Feed:
    feed = Feed(RecordSource(*files))
    while feed.loading:
        feed.now()
    return feed


def shown(feed: Feed, stamp: float) -> View:
    feed.playhead.go(Place(1, stamp))
    return feed.now()


def test_a_moment_of_a_record_is_that_of_its_run(recorded: tuple[Path, Simulation]) -> None:
    path, simulation = recorded
    feed, trace = loaded(path), simulation.trace
    for stamp in (0.5, 1.5, 2.3):
        view = shown(feed, stamp)
        state = view.snapshot.state
        assert state is not None
        row = int(np.abs(trace.times - stamp).argmin())
        np.testing.assert_allclose(state.poses, trace.poses[row], atol=2e-3)
        assert state.faults[LinkId(1, 2)].cut == (1.0 <= stamp < 2.0)
        assert set(view.snapshot.statuses) == {1, 2, 3}
        assert len(view.beliefs) == 3
        assert max(belief.error for belief in view.beliefs) < 0.05
    ages = [shown(feed, stamp).links[0].age for stamp in (0.9, 1.95)]
    assert ages[0] is not None
    assert ages[1] is not None
    assert ages[0] < 0.25
    assert ages[1] > 0.4
    assert ("cut", "1→2 cut") in [(mark.kind, mark.label) for _, mark in feed.tape.marks()]
    assert feed.export_buffer.data() is not None


def test_a_second_record_is_the_ghost(recorded: tuple[Path, Simulation], tmp_path: Path) -> None:
    path, _ = recorded
    other = tmp_path / "other.mcap"
    simulation = record(other, scenario("faults=[]"))
    feed = loaded(path, other)
    view = shown(feed, 2.0)
    ghost = view.ghosts.poses(2.0)
    assert ghost is not None
    trace = simulation.trace
    np.testing.assert_allclose(ghost, trace.poses[int(np.abs(trace.times - 2.0).argmin())], atol=2e-3)
    assert view.snapshot.state is not None
    assert view.snapshot.state.compare == "other"
    series, seconds = feed.compared(view)
    assert seconds > 2.0
    assert np.isfinite(series["ghost_distance"]).mean() > 0.9


@pytest.mark.parametrize("damage", ["cut short", "a hole"])
def test_a_damaged_record_is_shown_as_far_as_it_can_be_read(
    recorded: tuple[Path, Simulation], tmp_path: Path, damage: str
) -> None:
    data = bytearray(recorded[0].read_bytes())
    if damage == "cut short":
        data = data[: int(0.7 * len(data))]
    else:
        middle = len(data) // 2
        data[middle : middle + 200] = bytes(200)
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data)
    feed = loaded(broken)
    assert feed.tape.episodes[0].ends > 0.5


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 something else", b"\x89MCAP0\r\n"])
def test_what_is_no_record_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "foreign.mcap"
    path.write_bytes(content)
    with pytest.raises(EchelonError, match="expected") as refused:
        next(rows(path))
    assert "\n" not in str(refused.value)


def test_events_are_of_the_kind_that_they_were(tmp_path: Path) -> None:
    path = tmp_path / "pushed.mcap"
    simulation = record(path, scenario("disturbances=[{robot=2, at=0.5, until=1, drift=[0.5, 0, 0]}]"))
    *_, last = rows(path)
    happened = [(event.kind, event.text) for event in simulation.world.events]
    assert {"push", "excursion", "fault"} <= {kind for kind, _ in happened}
    assert [(event.kind, event.text) for event in last.state.events] == happened[: len(last.state.events)]


def test_the_page_of_a_record_waits_for_no_network_and_no_kernels() -> None:
    unneeded = "{'zenoh', 'numba', 'agents', 'world'}"
    code = f"import sys, cli.replay, runtime.replay.process; print(*{unneeded} & set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=60)
    assert found.stdout.split() == []
