"""Laws of `converged`: a solver that fails is one event, so is its recovery, and the summary has its share."""

from collections.abc import Sequence
from typing import Any

import pytest

from agents.agent import Agent
from agents.controllers.interface import Observation, Solution
from formation.scenario.files import load
from tests import builders
from tests.builders import command
from world.world import World


class _FailsAt:
    """A controller whose solver fails at some ticks."""

    def __init__(self, agent: Agent, ticks: Sequence[int]) -> None:
        self._inner, self._ticks = agent._controller, ticks

    def plan(self, observation: Observation) -> Solution:
        solution = self._inner.plan(observation)
        return Solution(solution.inputs, converged=observation.k not in self._ticks)


def test_an_agent_reports_that_its_newest_plan_is_a_fallback() -> None:
    scenario = load("circle", {"controller": {"plan_every": 2}})
    agent = Agent(scenario, 1)
    agent._controller = _FailsAt(agent, (2,))
    poses = scenario.start_poses()
    said = [agent.step(builders.tick(k, poses)).command.converged for k in range(6)]
    assert said == [True, True, False, False, True, True]
    assert agent.status(5, 0.05).converged


def drive(world: World, failing: Any, ticks: int) -> list[tuple[str, str]]:
    for _ in range(ticks):
        world.advance({1: command(1, world.k, planned=True, converged=not failing(world.k))})
    return [(event.severity, event.text) for event in world.events if "solver" in event.text]


def test_a_failure_is_one_event_and_so_is_the_recovery() -> None:
    told = drive(World(load("circle")), lambda k: 50 <= k < 100 and k % 3 == 0, 300)
    assert [severity for severity, _ in told] == ["error", "info"]
    assert all("robot 1" in text for _, text in told)


@pytest.mark.parametrize("failures", [0, 3, 10])
def test_the_summary_has_the_share_of_plans_that_converged(failures: int) -> None:
    world = World(load("circle", {"duration": 1}))
    drive(world, lambda k: k < failures, 10)
    robots = world.summary()["robots"]
    assert robots["1"]["converged"] == pytest.approx(1.0 - failures / 10)
    assert robots["2"]["converged"] is None
