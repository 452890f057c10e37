"""Agents share processes where there are more than the machine bears with one each; every robot has one agent."""

import contextlib
import multiprocessing
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime import fork_server
from runtime.machine import sharing
from runtime.machine.capacity import Capacity, cores
from runtime.machine.sharing import SURE, Sharing
from runtime.process_list import RunPlan, agents


@given(st.sets(st.integers(1, 1024), min_size=1, max_size=40), st.integers(1, 50))
def test_every_robot_has_one_agent_whoever_shares_a_process(robots: set[int], together: int) -> None:
    found = agents(RunPlan("x", "", "unixsock-stream/x", (), together=together), robots)
    assert sorted(robot for program in found for robot in program.robots) == sorted(robots)
    assert len(found) == -(-len(robots) // together)
    assert len({program.name for program in found}) == len(found)


def test_who_is_few_has_a_process_and_who_is_many_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Capacity] = []

    def measured() -> Capacity:
        asked.append(Capacity(cores(), 40, 90))
        return asked[-1]

    monkeypatch.setattr(sharing, "_measured_aside", measured)
    told: list[str] = []
    found = Sharing(told.append)
    assert found.size(SURE * cores()) == 1
    assert not asked
    assert found.size(40) == 1 or SURE * cores() >= 40
    assert not told
    many = 50 * cores()
    assert found.size(many) * cores() == many
    assert len(told) == 1
    assert "about 40 with a process each" in told[0]
    found.size(many)
    assert len(told) == len(asked) == 1
    assert Sharing(told.append, 3).size(many) == 3


def test_in_lockstep_many_share_a_process_a_core_and_nothing_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sharing, "_measured_aside", lambda: pytest.fail("measured"))
    monkeypatch.setattr(sharing, "cores", lambda: 3)
    told: list[str] = []
    found = Sharing(told.append, lockstep=True)
    assert found.size(3 * SURE) == 1
    assert not told
    assert found.size(3 * SURE + 1) == SURE + 1
    assert found.size(64) == 22
    assert found.size(64) == 22
    assert [line.partition(":")[0] for line in told] == ["13 agents", "64 agents"]
    assert "lockstep" in told[0]
    assert "up to 22 share one" in told[1]
    assert Sharing(told.append, 1, lockstep=True).size(64) == 1


def test_a_ctrl_c_that_comes_while_the_measuring_process_starts_leaves_no_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    @contextlib.contextmanager
    def held() -> Iterator[None]:
        yield
        raise KeyboardInterrupt

    before = set(multiprocessing.active_children())
    fork_server.start()
    monkeypatch.setattr(fork_server, "held_signals", held)
    with pytest.raises(KeyboardInterrupt):
        sharing._measured_aside()
    assert set(multiprocessing.active_children()) == before


def test_who_measures_for_nobody_any_more_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sharing, "measured", lambda: Capacity(1, 2, 3))
    ours, theirs = multiprocessing.Pipe(duplex=False)
    ours.close()
    sharing._measure(theirs)
