"""Laws of killing and restarting agents: the world says who is to be down, and only where somebody can do it."""

from typing import Any

import pytest

from formation.errors import EchelonError
from formation.scenario.files import load
from formation.schema import MAX_ROBOTS
from network.control import Kill, Restart, operation
from network.requests import Request
from world.presence import SUSPECT_SECONDS, AgentPresence
from world.rate import Rate
from world.run_control import RunControl
from world.world import World


class _Clock:
    now = 100.0


@pytest.fixture
def clock() -> _Clock:
    return _Clock()


def run_of_three() -> tuple[World, AgentPresence, RunControl]:
    world = World(load("triangle-circle"), endless=True)
    roster = AgentPresence(world)
    roster.launcher = True
    for robot in (1, 2, 3):
        roster.appear(robot)
    return world, roster, RunControl(world, Rate(0.0), roster, go=True)


def dies(roster: AgentPresence, clock: _Clock, robot: int) -> None:
    roster.disappear(robot, clock.now)
    clock.now += 2.0 * SUSPECT_SECONDS
    roster.settle(clock.now)


def test_a_killed_agent_stays_down_until_it_is_restarted(clock: _Clock) -> None:
    world, roster, orders = run_of_three()
    orders.obey(Kill(robot=2))
    assert roster.dismissed == [2]
    dies(roster, clock, 2)
    assert (roster.dismissed, roster.missing) == ([2], [2])
    orders.obey(Restart(robot=2))
    assert (roster.dismissed, roster.missing) == ([], [2])
    roster.appear(2)
    assert sorted(world.live) == [1, 2, 3]


def test_an_agent_that_lives_is_down_only_for_a_moment_when_it_is_restarted(clock: _Clock) -> None:
    _, roster, orders = run_of_three()
    orders.obey(Restart(robot=3))
    assert roster.dismissed == [3]
    orders.obey(Restart(robot=3))  # an impatient person
    dies(roster, clock, 3)
    assert roster.dismissed == []


def test_who_is_killed_while_being_restarted_stays_down(clock: _Clock) -> None:
    _, roster, orders = run_of_three()
    orders.obey(Restart(robot=1))
    orders.obey(Kill(robot=1))
    dies(roster, clock, 1)
    assert roster.dismissed == [1]


def test_an_agent_that_is_coming_back_anyway_is_not_killed(clock: _Clock) -> None:
    _, roster, orders = run_of_three()
    dies(roster, clock, 1)
    orders.obey(Restart(robot=1))
    assert roster.dismissed == []


def test_a_new_episode_does_not_wait_for_the_killed(clock: _Clock) -> None:
    world, roster, orders = run_of_three()
    orders.obey(Kill(robot=2))
    dies(roster, clock, 2)
    world.reset()
    assert orders.status == "running"
    dies(roster, clock, 3)
    assert str(orders.status) == "waiting"


def test_without_a_launcher_nobody_is_killed() -> None:
    _, roster, orders = run_of_three()
    roster.launcher = False
    for order in (Kill(robot=2), Restart(robot=2)):
        with pytest.raises(EchelonError, match="nobody here can end or start agents"):
            orders.obey(order)
    assert roster.dismissed == []
    roster.keepers.add(7)  # as in containers
    orders.obey(Kill(robot=2))
    assert roster.dismissed == [2]


def test_only_robots_of_the_scenario_are_killed() -> None:
    _, _, orders = run_of_three()
    with pytest.raises(EchelonError, match="expected a robot of the scenario, 1 to 3; got 4"):
        orders.obey(Kill(robot=4))


@pytest.mark.parametrize("robot", [0, MAX_ROBOTS + 1, -1, 1.5, "2", None, True])
def test_what_is_no_number_of_a_robot_is_refused(robot: Any) -> None:
    for name in ("kill", "restart"):
        with pytest.raises(EchelonError, match="robot"):
            operation(Request(name, {"robot": robot}))
