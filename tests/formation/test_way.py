"""Laws of the reference that follows from previews (formation/way.py)."""

import numpy as np
import pytest

from formation.arrays import FloatArray
from formation.errors import ScenarioError
from formation.metrics import wrapped
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from formation.way import BRAKE, HOLD, HeardReference
from runtime.inprocess import Simulation

MICRO = 1e-6


def told(name: str = "triangle-circle", **more: object) -> Scenario:
    """A shipped scenario whose path robot 1 alone knows."""
    kind = load(name).path.kind
    return load(name, {"path": {"kind": kind, "known_to": "leader"}, **more})


def heard(scenario: Scenario) -> tuple[HeardReference, int]:
    """What robot 2 knows at the start, and the ticks of one preview."""
    return scenario.heard_reference([2, 1]), scenario.stride * scenario.controller.horizon


@pytest.mark.parametrize("name", ["triangle-circle", "square-figure8"])
def test_slots_from_previews_are_those_of_the_path(name: str) -> None:
    scenario = told(name)
    own, ticks = heard(scenario)
    known = scenario.reference([2, 1])
    for k in range(0, 400, 3):
        own.hear(known.preview(k), k + 1)
    k = 399
    mine, path = own.block(k), known.block(k)
    rows = np.arange(k, k + ticks - scenario.stride)
    for values, wanted in ((mine.slots, path.slots), (mine.inputs, path.inputs)):
        assert np.abs(values[rows - mine.first] - wanted[rows - path.first]).max() < 3 * MICRO


@pytest.mark.parametrize("k", [500, 3000, 3200, 20_000])
def test_a_robot_that_begins_in_the_middle_of_an_episode_has_the_slots_of_the_others(k: int) -> None:
    """Its agent was started again: however long the episode, what it hears first is enough."""
    scenario = told()
    own, ticks = heard(scenario)
    known = scenario.reference([2, 1])
    own.forget()
    assert own.hear(known.preview(k), k + 1)
    mine, path = own.block(k + 1), known.block(k + 1)
    rows = np.arange(k + 1, k + ticks - scenario.stride)
    apart = mine.slots[rows - mine.first] - path.slots[rows - path.first]
    apart[..., 2] = wrapped(apart[..., 2])
    assert np.abs(apart).max() < 3 * MICRO


def test_beyond_the_preview_the_slots_go_on_then_stand_still() -> None:
    scenario = told()
    own, ticks = heard(scenario)
    known = scenario.reference([2, 1])
    tick = scenario.control_interval
    held, stopped = ticks + round(HOLD / tick), ticks + round((HOLD + BRAKE) / tick)
    assert np.abs(own.block(held).slots[held] - known.block(held).slots[held]).max() < 1e-3
    block = own.block(stopped + 100)
    assert np.all(block.slots[stopped + 2] == block.slots[stopped + 100])
    assert np.all(block.inputs[stopped + 2] == 0.0)
    assert not own.lost(ticks)
    assert own.lost(ticks + 1)


@pytest.mark.parametrize(("deaf", "back"), [(800, 1800), (1500, 3000), (2600, 4200)])
def test_a_robot_that_hears_again_comes_back_without_a_jump_however_far_it_is(deaf: int, back: int) -> None:
    scenario = told()
    own, _ = heard(scenario)
    known = scenario.reference([2, 1])
    places = []
    for k in range(deaf, back + 1):
        own.hear(known.preview(k), k + 1)
        block = own.block(k + 1)
        places.append(block.slots[k + 1 - block.first, :, :2].copy())
    moved = np.hypot(*np.moveaxis(np.diff(places, axis=0), -1, 0)) / scenario.control_interval
    assert moved.max() < scenario.robots.limits.v
    assert np.abs(np.diff(moved, axis=0)).max() < 0.01
    assert np.abs(places[-1] - known.block(back + 1).slots[back + 1 - known.block(back + 1).first, :, :2]).max() < 0.001
    assert not own.lost(back)


def test_an_older_preview_and_one_from_the_future_are_not_taken() -> None:
    scenario = told()
    own, _ = heard(scenario)
    known = scenario.reference([2, 1])
    assert own.hear(known.preview(10), 12)
    assert not own.hear(known.preview(9), 13)
    assert not own.hear(known.preview(10), 13)
    assert not own.hear(known.preview(500), 14)
    assert own.age(14) == pytest.approx(0.04)


def places(scenario: Scenario) -> FloatArray:
    """Where the robots are, tick by tick: (T, n, 2) [m]."""
    return Simulation(scenario).simulate().poses[..., :2]


@pytest.mark.parametrize("name", ["triangle-circle", "square-figure8"])
def test_on_time_robots_that_are_told_drive_as_if_they_knew(name: str) -> None:
    apart = places(told(name, duration=3.0)) - places(load(name, {"duration": 3.0}))
    assert 0.0 < np.abs(apart).max() < 10 * MICRO


def test_knowledge_is_one_hop_older_from_robot_to_robot() -> None:
    latency = 0.3
    simulation = Simulation(told("square-figure8", duration=3.0, link={"latency": latency}))
    trace = simulation.simulate()
    world = simulation.world
    ages = [agent.status(world.k - 1, world.now).way_age for agent in simulation.agents.values()]
    assert ages[0] == 0.0
    assert np.diff(ages) == pytest.approx(latency, abs=0.021)
    assert np.abs(trace.errors()[0]).max() < 0.001


def test_a_cut_is_seen_and_healed_without_a_contact() -> None:
    cut = {"link": "1->2", "cut": True, "at": 1.0, "until": 6.0}
    simulation = Simulation(told("square-figure8", duration=14.0, faults=[cut]))
    lost = set()
    while not simulation.finished:
        simulation.step()
        lost |= {(simulation.world.k, robot) for robot, agent in simulation.agents.items() if agent.status(0, 0.0).lost}
    worst = np.abs(simulation.trace.errors()[0]).max(axis=1)
    assert worst[:301].max() < 0.001
    assert worst[600] > 0.02
    assert worst[-1] < 0.001
    assert {robot for _, robot in lost} == {2, 3, 4}
    assert max(k for k, _ in lost) < 1100


@pytest.mark.parametrize("name", ["paper", "leader_follower", "virtual_structure", "centralised"])
def test_a_controller_that_needs_the_path_is_refused_in_one_line(name: str) -> None:
    with pytest.raises(ScenarioError, match=f"path.known_to: {name} needs the path") as refused:
        told(controller={"name": name})
    assert "consensus" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_consensus_follows_what_it_is_told() -> None:
    controller = {"name": "consensus"}
    known = load("triangle-circle", {"controller": controller, "duration": 3.0})
    apart = places(told(controller=controller, duration=3.0)) - places(known)
    assert np.abs(apart).max() < 10 * MICRO
