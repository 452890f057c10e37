"""Laws of `verify`: a record of a lockstep run is its run to the last bit, and what was changed in it is named."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from formation.errors import EchelonError
from records.file import RecordFile
from records.record import Record, load
from records.scanning import Note, scan
from runtime.inprocess import Simulation
from runtime.recording import Recording
from runtime.verification import verify
from tests.records.recorded import STARTED, record, scenario

FOREIGN = {**json.loads(scenario().model_dump_json(exclude_unset=True)), "controller": {"name": "mine"}}
"""With a controller that this installation does not have."""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("records") / "run.mcap"
    record(found, scenario("noise={slip=0.2, position=0.001}"))
    return found


@pytest.fixture
def read(path: Path) -> Record:
    return load(path)


def test_a_record_is_its_run_to_the_last_bit(read: Record) -> None:
    (verdict,) = verify(read)
    assert (verdict.ticks, verdict.until, verdict.difference, verdict.remark) == (251, 2.5, "", "")


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("drive-me", ["duration=3", "path.commands=[[0, 0.1, 0], [1, 0.1, 0.3]]"]),
        ("follow-the-leader", ["duration=2"]),
        ("triangle-circle", ["duration=2", "controller.name=centralised"]),
    ],
)
def test_so_is_one_of_any_scenario(tmp_path: Path, name: str, settings: list[str]) -> None:
    from formation.scenario import files

    record(tmp_path / "run.mcap", files.load(name, settings))
    (verdict,) = verify(load(tmp_path / "run.mcap"))
    assert not verdict.difference
    assert verdict.ticks > 200


def test_a_record_of_a_run_that_outlived_its_world_is_verified_segment_by_segment(tmp_path: Path) -> None:
    simulation = Simulation(scenario("noise={slip=0.2, position=0.001}"))
    with RecordFile(tmp_path / "run.mcap") as file:
        recording = Recording(simulation, file, STARTED, "default")
        saved = []
        while not simulation.finished:
            recording.step()
            if simulation.world.k in (90, 160):
                simulation.go_on()
                recording.go_on()
                saved.append(simulation.world.k)
    read = load(tmp_path / "run.mcap")
    assert [list(episode.resumed) for episode in read.episodes] == [[], saved[:1], saved]
    assert [episode.ticks[0] for episode in read.episodes] == [0, *saved]
    verdicts = verify(read)
    assert not any(verdict.difference for verdict in verdicts)
    assert all(v.until > end - 0.05 for v, end in zip(verdicts, (0.9, 1.6, 2.5), strict=True))  # a last part is lost
    read.episodes[1].resumed = ()
    assert "tick 9" in verify(read)[1].difference  # the cold agents do not do what the others would have done


def test_one_bit_of_one_pose_is_named(read: Record) -> None:
    (episode,) = read.episodes
    poses = np.array(episode.poses[100])
    poses[1, 2] = np.nextafter(poses[1, 2], 9.0)
    episode.poses[100] = poses
    (verdict,) = verify(read)
    assert "tick 100 (t = 1.00 s), robot 2" in verdict.difference
    assert verdict.ticks == 100


def test_one_bit_of_one_checksum_is_named(read: Record) -> None:
    (episode,) = read.episodes
    sums = list(episode.checks[137])
    episode.checks[137] = (*sums[:2], sums[2] ^ 1)
    (verdict,) = verify(read)
    assert "tick 137 (t = 1.37 s), robot 3" in verdict.difference


def test_an_order_that_was_removed_is_named_and_so_is_where_it_shows(read: Record) -> None:
    (episode,) = read.episodes
    (cut,) = [order for order in episode.orders if order.tick == 100]
    episode.orders.remove(cut)
    (verdict,) = verify(read)
    assert verdict.remark == f"order {cut.number} is not in the record"
    assert "robot 2" in verdict.difference  # which hears robot 1 although the link is cut
    assert 100 < int(verdict.difference.split()[1]) < 200


def test_an_order_that_was_changed_shows(read: Record) -> None:
    (episode,) = read.episodes
    episode.orders = [replace(order, value={}) if order.tick == 100 else order for order in episode.orders]
    (verdict,) = verify(read)
    assert verdict.difference


def edited(path: Path, new: Path, name: str, change: Callable[[dict[str, str]], None]) -> Record:
    """A copy with other metadata."""
    with RecordFile(new) as file:
        for item in scan(path):
            if isinstance(item, Note):
                values = dict(item.values)
                if item.name == name:
                    change(values)
                file.note(item.name, values)
    return load(new)


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("echelon", {"version": "2"}, "expected a record of wire version .*; .* is of version 2"),
        ("episode", {"mode": "realtime"}, "depends on the wall clock"),
        ("episode", {"scenario": json.dumps(FOREIGN)}, "controller.name: expected one of .*; got 'mine'"),
    ],
)
def test_what_cannot_be_simulated_again_is_refused_in_a_line(
    path: Path, tmp_path: Path, name: str, values: dict[str, str], words: str
) -> None:
    with pytest.raises(EchelonError, match=words) as caught:
        verify(edited(path, tmp_path / "new.mcap", name, lambda found: found.update(values)))
    assert "\n" not in str(caught.value)


def test_what_is_compared_ends_where_an_agent_was_missing(read: Record) -> None:
    (episode,) = read.episodes
    episode.orders.append(replace(episode.orders[-1], number=3, tick=170, kind="agents", value={"answered": [1, 3]}))
    (verdict,) = verify(read)
    assert (verdict.ticks, verdict.difference) == (171, "")
    assert "only 1, 3" in verdict.remark
