"""Laws of real robots in the world: they are where they say, agents see no difference, and who is silent is lost."""

from typing import Any

import numpy as np
import pytest

from formation.errors import EchelonError, ScenarioError
from formation.scenario.files import load
from network import topics
from network.bodies import BodyInput, BodyPose
from network.bus import Publish, Query, Reject, Sample
from network.codec import decode, encode
from network.interventions import Move, Push
from network.requests import Request
from tests.builders import command
from world.bodies.mixed import MixedBodies
from world.real_robots import FIRST_SECONDS, LOST_SECONDS, MixedWorld, RealRobots

POSE = np.array([0.7, -0.1, 1.25])


def mixed(*settings: str, real: tuple[int, ...] = (2,)) -> tuple[MixedWorld, RealRobots]:
    robots = RealRobots("test", real)
    return MixedWorld(load("triangle-circle", list(settings)), robots, episode=3, endless=False), robots


def pose(robot: int = 2, values: Any = POSE, age: float = 0.0, key: int | None = None) -> Sample:
    message = BodyPose(robot, 1, 0.0, 3, np.array(values), np.array([0.25, -0.5]), age)
    return Sample(topics.body_pose("test", key or robot), encode(message))


def test_a_real_robot_is_where_it_says_and_the_others_are_simulated() -> None:
    world, robots = mixed()
    assert isinstance(world.plant, MixedBodies)
    robots.take([pose()], 10.0)
    first = world.tick()
    assert first.poses[1].tolist() == POSE.tolist()
    assert first.localised == [1, 2, 3]
    assert first.odometry[1].tolist() == [0.25, -0.5]
    before = world.plant.poses
    world.advance({i: command(i, 0, episode=3, v=0.5) for i in world.robots})
    moved = np.linalg.norm(world.plant.poses[:, :2] - before[:, :2], axis=1)
    assert moved == pytest.approx([0.005, 0.0, 0.005], abs=1e-6)
    assert world.plant.poses[1].tolist() == POSE.tolist()


def test_a_pose_is_delivered_once_and_one_that_never_came_is_not() -> None:
    world, robots = mixed()
    assert world.tick().localised == [1, 3]
    robots.take([pose()], 10.0)
    world.advance({})
    assert world.tick().localised == [1, 2, 3]
    world.advance({})
    assert world.tick().localised == [1, 3]


def test_a_real_robot_is_localised_when_simulated_localisation_says_nothing() -> None:
    world, robots = mixed("bodies.localisation.rate=10")
    world.tick()
    world.advance({})
    robots.take([pose()], 10.0)
    tick = world.tick()
    assert (tick.measured, tick.localised) == (1, [2])
    assert tick.poses[1].tolist() == POSE.tolist()


def test_relative_sensing_is_of_where_robots_really_are() -> None:
    world, robots = mixed("bodies.relative.sigma=0.0")
    robots.take([pose()], 10.0)
    tick = world.tick()
    x, y, theta = POSE
    ahead = world.plant.poses[0, :2] - (x, y)
    turn = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
    assert tick.relatives[1] == pytest.approx(turn @ ahead)


def asked(items: list[Any]) -> list[tuple[str, dict[str, Any]]]:
    assert all(isinstance(item, Query) for item in items)
    requests = [decode(Request, item.payload) for item in items]
    return [(request.operation, request.arguments) for request in requests]


def test_who_is_silent_is_lost_until_it_speaks_again() -> None:
    world, robots = mixed()
    world.live = {1, 2, 3}
    assert not robots.watch(world, 0.0)
    assert not robots.watch(world, FIRST_SECONDS - 0.1)  # its process is still starting
    robots.take([pose(age=0.1)], 5.0)
    assert not robots.watch(world, 4.9 + LOST_SECONDS)
    assert asked(robots.watch(world, 5.0 + LOST_SECONDS)) == [("kill", {"robot": 2})]
    assert not robots.watch(world, 5.1 + LOST_SECONDS)  # once, while it is carried out
    assert world.events[-1].text == "robot 2 is lost: no pose for 0.5 s"
    world.live = {1, 3}
    assert not robots.watch(world, 9.0)
    robots.take([pose()], 9.1)
    assert asked(robots.watch(world, 9.1)) == [("restart", {"robot": 2})]
    world.live = {1, 2, 3}
    assert not robots.watch(world, 9.3)
    assert world.events[-1].text == "robot 2 is back"


def test_an_agent_that_its_user_has_killed_is_not_brought_back() -> None:
    world, robots = mixed()
    robots.take([pose()], 0.0)
    world.live = {1, 3}
    assert not robots.watch(world, 0.1)


def test_a_robot_is_told_once_per_tick_what_its_links_and_the_watchdog_let_through() -> None:
    world, robots = mixed("faults=[{at=0, link='2->world', cut=true}]", real=(1, 2))
    assert not robots.inputs(world)  # nothing has been commanded
    world.advance({i: command(i, 0, episode=3, v=0.5, omega=0.25) for i in world.robots})
    sent = robots.inputs(world)
    assert all(isinstance(action, Publish) for action in sent)
    found: list[Any] = [action.message for action in sent if isinstance(action, Publish)]
    assert [(type(one), one.v, one.omega) for one in found] == [(BodyInput, 0.5, 0.25), (BodyInput, 0.0, 0.0)]
    assert [action.key for action in sent if isinstance(action, Publish)] == robots.inputs_to
    assert not robots.inputs(world)


@pytest.mark.parametrize("sample", [pose(3), pose(2, key=1), Sample(topics.body_pose("test", 2), b"rubbish")])
def test_only_a_real_robots_own_body_says_where_it_is(sample: Sample) -> None:
    world, robots = mixed()
    rest, actions = robots.take([sample], 0.0)
    assert not rest
    assert isinstance(actions[0], Reject)
    assert world.tick().localised == [1, 3]


def test_a_real_robot_is_not_pushed_and_its_user_is_told() -> None:
    world, _ = mixed()
    for order in (Push(robot=2, kind="gust"), Move(robot=2, dx=0.1, dy=0.0)):
        with pytest.raises(EchelonError, match="robot 2 is a real one: push it by hand"):
            world.intervene(order)
    world.intervene(Push(robot=1, kind="gust"))
    with pytest.raises(ScenarioError, match="robot 2 is a real one"):
        mixed("disturbances=[{robot=2, at=1.0, drift=[0.1, 0.0, 0.0]}]")


def test_real_robots_stand_beside_wheeled_ones_only() -> None:
    with pytest.raises(ScenarioError, match="expected wheeled beside real robots"):
        mixed("bodies.implementation=mujoco")
