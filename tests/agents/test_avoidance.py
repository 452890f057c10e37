"""Laws of the last filter: with nothing near it changes nothing; nobody touches; who is in the way is passed."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.avoidance import Avoidance
from agents.motor_model import MotorModel
from formation import unicycle
from formation.arrays import FloatArray
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.messages import WORLD, Tick
from runtime.inprocess import Simulation, simulate
from world.sight import CROWD, Sight
from world.world import World

SCENARIO = load("triangle-circle", {"robots": {"avoid": True}})
DT = SCENARIO.control_interval
TOUCH = 2.0 * SCENARIO.bodies.radius
STILL = np.zeros((3, 2))


def filter_of(scenario: Scenario) -> Avoidance:
    limits = np.array([scenario.robots.limits.v, scenario.robots.limits.omega])
    return Avoidance(scenario, 1, MotorModel(scenario, limits))


def tick_of(k: int, place: tuple[float, float], odometry: FloatArray = STILL) -> Tick:
    """Robot 1 sees robot 2 at a place in its own frame."""
    seen = np.array([[1.0, *place]])
    return Tick(WORLD, k, k * DT, 0, 0, odometry, [], None, np.zeros((0, 3)), [], np.zeros((0, 2)), seen=seen)


def beside(place: tuple[float, float]) -> Avoidance:
    """The filter of robot 1, which stands and has seen robot 2 stand at a place for a while."""
    found = filter_of(SCENARIO)
    for k in range(5):
        found.look(tick_of(k, place))
    return found


@given(st.floats(-0.5, 0.5), st.floats(-2.0, 2.0), st.floats(0.0, 6.28))
def test_with_nothing_near_the_command_is_the_very_same(v: float, omega: float, where: float) -> None:
    far = (0.5 * math.cos(where), 0.5 * math.sin(where))
    assert beside(far).filter(5, STILL[0], v, omega) == (v, omega)
    assert filter_of(SCENARIO).filter(5, STILL[0], v, omega) == (v, omega)


@pytest.mark.parametrize("preset", ["ideal", "mocap", "rough", "duckiebot"])
@pytest.mark.parametrize("v", [0.1, 0.5, -0.5])
def test_a_robot_stops_before_one_that_stands(preset: str, v: float) -> None:
    scenario = load(
        "triangle-circle", {"bodies": {"preset": preset, "relative": {"sigma": 0.0}}, "robots": {"avoid": True}}
    )
    known, avoidance = scenario.nominal, filter_of(scenario)
    touch = 2.0 * scenario.bodies.radius
    pose, obstacle, wheel = (0.0, 0.0, 0.0), math.copysign(touch + 0.4, v), 0.0
    waiting = [0.0] * known.delay
    least = math.inf
    for k in range(120):
        avoidance.look(tick_of(k, (obstacle - pose[0], 1e-9), np.array([[wheel, 0.0]] * 3)))
        command, _ = avoidance.filter(k, np.array([wheel, 0.0]), v, 0.0)
        avoidance._motors.command(k, command, 0.0)
        waiting.append(command)
        acting = waiting.pop(0)
        share = 1.0 - math.exp(-DT / known.lag) if known.lag else 1.0
        wheel += min(max(share * (acting - wheel), -known.acceleration * DT), known.acceleration * DT)
        pose = unicycle.step(*pose, wheel, 0.0, DT)
        least = min(least, abs(obstacle - pose[0]) - touch)
    assert least > 0.0


@pytest.mark.parametrize("preset", ["camera", "rough", "duckiebot"])
@pytest.mark.parametrize("robot", [1, 2, 3, 4])
def test_nobody_hits_a_robot_of_the_formation_that_stops_at_once(preset: str, robot: int) -> None:
    """It is stuck from one tick to the next, in front of one whose commands act later."""
    stuck = {"robot": robot, "at": 4.0, "until": 8.0, "drive": 0.0}
    given = {"bodies": {"preset": preset}, "duration": 8.0, "robots": {"avoid": True}, "disturbances": [stuck]}
    assert simulate(load("square-figure8", given))["contacts"] == 0


def test_a_stuck_robot_whose_wheels_turn_gives_no_more_than_would_be_good_if_it_came_free() -> None:
    """Its odometry says that the body ahead leaves at the speed of its wheels; the slip says that it stands."""
    speed, place = 0.4, (TOUCH + 0.03, 1e-9)
    wheels, odometry = np.array([speed, 0.0]), np.array([[speed, 0.0]] * 3)
    given_by = {}
    for slip in (0.0, -speed):
        avoidance = filter_of(SCENARIO)
        for k in range(40):
            avoidance.look(tick_of(k, place, odometry))
            avoidance.near(k, wheels, np.zeros(3), np.array([slip, 0.0]), np.zeros(3))
        given_by[slip], _ = avoidance.filter(39, wheels, 0.5, 0.0)
    free = beside(place).filter(5, STILL[0], 0.5, 0.0)[0]
    assert given_by[0.0] == 0.5
    assert given_by[-speed] == pytest.approx(free, abs=0.02)
    assert free < speed


@pytest.mark.parametrize("slip", [0.0, 0.1, -0.1])
def test_a_plan_is_told_where_bodies_are_in_the_world_and_how_fast(slip: float) -> None:
    speed, pose = 0.2, np.array([2.0, -1.0, 0.5 * math.pi])
    avoidance = filter_of(SCENARIO)
    wheels = np.array([speed, 0.0])
    for k in range(60):
        avoidance.look(tick_of(k, (0.2, 0.1), np.array([wheels] * 3)))
        (found,) = avoidance.near(k, wheels, pose, np.array([slip, 0.0]), pose)
    np.testing.assert_allclose(found[:2], [2.0 - 0.1, -1.0 + 0.2], atol=1e-6)
    np.testing.assert_allclose(found[2:4], [0.0, speed + slip], atol=1e-6)
    room = SCENARIO.spacing - TOUCH
    assert found[4] == TOUCH
    assert 0.5 * room < found[5] - TOUCH < room


def test_robots_see_who_is_within_sight_in_their_own_frame() -> None:
    poses = np.array([[0.0, 0.0, math.pi / 2.0], [0.0, 0.9, 0.0], [0.0, 1.5, 0.0]])
    seen = Sight(SCENARIO).see(0, poses)
    assert [divmod(int(who), 3) for who in seen[:, 0]] == [(0, 1), (1, 0), (1, 2), (2, 1)]
    np.testing.assert_allclose(seen[0, 1:], [0.9, 0.0], atol=1e-12)


@pytest.mark.parametrize("sigma", [0.0, 0.01])
def test_of_a_crowd_everybody_sees_the_nearest(sigma: float) -> None:
    robots = {"avoid": True, "sight": 2.0}
    shape = {"shape": "line", "robots": 200, "spacing": 0.02}
    crowd = load("circle", {"formation": shape, "robots": robots, "bodies": {"relative": {"sigma": sigma}}})
    draws = np.random.default_rng(1)
    poses = np.column_stack([draws.uniform(0.0, 3.0, (200, 2)), draws.uniform(-3.0, 3.0, 200)])
    seen = Sight(crowd).see(5, poses)
    who, whom = np.divmod(seen[:, 0].astype(int), 200)
    apart = np.hypot(*(poses[None, :, :2] - poses[:, None, :2]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    for row in range(200):
        near = np.sort(np.argsort(apart[row])[: CROWD - 1])
        assert whom[who == row].tolist() == near[apart[row, near] <= 2.0].tolist()
    np.testing.assert_allclose(np.hypot(seen[:, 1], seen[:, 2]), apart[who, whom], atol=6.0 * sigma + 1e-9)
    assert np.array_equal(seen, Sight(crowd).see(5, poses))


def test_nobody_looks_without_the_filter() -> None:
    assert len(World(load("triangle-circle")).tick().seen) == 0
    assert len(World(SCENARIO).tick().seen) == 6


def outcome(name: str, **overrides: Any) -> tuple[int, float, Any]:
    """Contacts beyond those of the start, the largest |l_e| of the last second [m], and the summary."""
    simulation = Simulation(load(name, overrides))
    touched = simulation.world.contacts.count
    error = simulation.simulate().errors()[0]
    return simulation.world.contacts.count - touched, float(np.abs(error[-100:]).max()), simulation.world.summary()


@pytest.mark.parametrize("preset", ["ideal", "mocap", "epuck"])
def test_a_formation_in_order_drives_as_without_the_filter(preset: str) -> None:
    start = {"duration": 8.0, "bodies": {"preset": preset}, "controller": {"plan_every": 4}}
    summaries = [outcome("follow-the-leader", robots={"avoid": avoid}, **start)[2] for avoid in (True, False)]
    assert len({summary["trajectory_sha256"] for summary in summaries}) == 1


@pytest.mark.parametrize(("name", "stuck"), [("square-figure8", 1), ("hexagon-sinusoid", 1)])
def test_a_stuck_robot_is_passed_and_comes_back_without_a_contact(name: str, stuck: int) -> None:
    case: dict[str, Any] = {
        "duration": 26.0,
        "controller": {"name": "virtual_structure", "plan_every": 4},
        "disturbances": [{"robot": stuck, "at": 4.0, "until": 14.0, "drive": 0.0}],
    }
    touched, _, _ = outcome(name, robots={"avoid": False}, **case)
    contacts, error, summary = outcome(name, robots={"avoid": True}, **case)
    assert touched > 0
    assert contacts == 0
    assert error < 0.001
    assert max(robot["kept_off_s"] for robot in summary["robots"].values()) > 1.0
    assert any(event["kind"] == "avoidance" for event in summary["events"])


def test_robots_that_start_in_each_others_places_pass_each_other() -> None:
    """Neither brakes for the other for ever, although the start is symmetric."""
    slots = load("circle").start_poses()
    swapped = [(float(x), float(y), float(theta)) for x, y, theta in slots[::-1]]
    case: dict[str, Any] = {"duration": 20.0, "controller": {"plan_every": 4}}
    touched, _, _ = outcome("circle", robots={"poses": swapped, "avoid": False}, **case)
    contacts, error, _ = outcome("circle", robots={"poses": swapped, "avoid": True}, **case)
    assert touched > 0
    assert contacts == 0
    assert error < 0.005
