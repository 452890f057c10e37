"""A keeper ends agents that are not wanted; those that shared a process with them share as those who are left do."""

from collections.abc import Iterable
from typing import Any

import pytest

from runtime.keeping.agent_keeper import AgentKeeper
from runtime.process_list import Program, RunPlan, agents
from runtime.supervisor import Supervisor
from tests import builders


class Process:
    """Is started, and killed."""

    def start(self) -> None:
        """Does nothing."""

    def kill(self) -> None:
        """Does nothing."""

    def join(self, timeout: float | None = None) -> None:
        """Does nothing."""


@pytest.fixture(name="supervisor")
def made(monkeypatch: pytest.MonkeyPatch) -> Supervisor:
    """A supervisor of processes that are none."""
    found = Supervisor("x", lambda line: None)

    def start(programs: Iterable[Program]) -> None:
        running: dict[Program, Any] = found._running
        running |= {program: Process() for program in programs}

    monkeypatch.setattr(found, "start", start)
    monkeypatch.setattr("runtime.supervisor.wait", lambda sentinels, timeout: None)
    return found


def test_of_a_smaller_scenario_agents_have_a_process_each_again(supervisor: Supervisor) -> None:
    size = 5

    def processes(robots: Iterable[int]) -> list[Program]:
        return agents(RunPlan("x", "", "unixsock-stream/x", (), together=size), robots)

    supervisor.start(processes(range(1, 11)))
    keeper = AgentKeeper(supervisor, processes)
    keeper.keep(builders.state(10, dismissed=[7]))
    assert {program.robots for program in (*supervisor._running, *supervisor._again)} == {
        frozenset({1, 2, 3, 4, 5}),
        frozenset({6, 8, 9, 10}),
    }
    size = 1
    keeper.keep(builders.state(3))
    assert {program.name for program in supervisor._again} == {"agent 1", "agent 2", "agent 3"}
    assert not supervisor._running
