"""Agents on bodies that are not ideal: nothing is used that was not given, silence costs what messages bought."""

import copy
from typing import Any

import numpy as np
import pytest

from agents.agent import Agent
from benchmarks.bodies_cells import Cell
from benchmarks.bodies_rows import PROTOTYPE
from formation.arrays import FloatArray
from formation.scenario.files import load
from formation.scenario.overrides import merged
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation

SCENARIO = "triangle-circle"
R = [1.0, 0.4]
"""Of both controllers alike."""


def trajectory(simulation: Simulation) -> FloatArray:
    return simulation.simulate().poses


@pytest.mark.parametrize("bodies", ["mocap", {"slip": 0.2, "gyro": 0.2}])
def test_nash_that_hears_nobody_is_virtual_structure(bodies: object) -> None:
    common = {"bodies": bodies, "duration": 6.0, "link": {"cut": True}, "estimator": {"relative": False}}
    silent = merged(common, {"controller": {"name": "nash", "waits": False, "r": R}})
    deaf = merged(common, {"controller": {"name": "virtual_structure", "r": R}})
    one, other = (trajectory(Simulation(load(SCENARIO, keys))) for keys in (silent, deaf))
    assert np.array_equal(one, other)


CAMERA: dict[str, Any] = {
    "duration": 6.0,
    "seed": 5,
    "bodies": {
        "preset": "camera",
        "robots": [{"robot": 1, "scale": 0.02, "slip": 0.3}, {"robot": 3, "turn_offset": -0.01}],
    },
    "disturbances": [{"robot": 2, "at": 2.0, "until": 4.0, "drive": 0.4}],
}
OTHER: dict[str, Any] = {
    "bodies": {
        "robots": [{"robot": 2, "scale": -0.03, "turn_scale": 0.03, "gyro": 0.9, "lag": 0.4}],
        "localisation": {"dropouts": [{"robot": 1, "at": 1.0, "until": 5.0}]},
    },
    "disturbances": [{"robot": 1, "at": 1.0, "until": 5.0, "drift": [0.1, 0.0, 0.0]}],
    "robots": {"poses": [[9.0, 9.0, 0.0], [8.0, 9.0, 1.0], [7.0, 9.0, 2.0]]},
}
"""What is the world's alone, replaced."""


@pytest.mark.parametrize("hears", ["upstream", "both"])
def test_an_agent_uses_nothing_that_is_the_worlds_alone(hears: str) -> None:
    keys = merged(CAMERA, {"controller": {"hears": hears}})
    honest, replaced = load(SCENARIO, keys), load(SCENARIO, merged(keys, OTHER))
    peeking = Simulation(honest)
    peeking.agents = {robot: Agent(replaced, robot) for robot in peeking.agents}
    assert np.array_equal(trajectory(peeking), trajectory(Simulation(honest)))
    assert not np.array_equal(trajectory(Simulation(replaced)), trajectory(Simulation(honest)))


@pytest.mark.parametrize("wished", [True, False])
def test_a_controller_is_told_of_disturbances_only_where_they_are_wished_for(wished: bool) -> None:
    pushed = [{"robot": robot, "at": 0.5, "until": 2.0, "drift": [0.01, 0.01, 0.0]} for robot in (1, 2, 3)]
    keys = {"bodies": "mocap", "duration": 2.0, "disturbances": pushed, "estimator": {"disturbances": wished}}
    simulation = Simulation(load(SCENARIO, keys))
    trajectory(simulation)
    for agent in simulation.agents.values():
        assert agent.observation is not None
        assert agent.observation.disturbance.any() == wished


def test_an_agent_that_is_copied_goes_on_as_it_would_have() -> None:
    scenario: Scenario = load(SCENARIO, CAMERA)
    whole = Simulation(scenario)
    copied = Simulation(scenario)
    for _ in range(250):
        copied.step()
    copied.agents = copy.deepcopy(copied.agents)
    assert np.array_equal(trajectory(copied), trajectory(whole))


@pytest.mark.parametrize("latency", [0.1, 0.3])
def test_the_delay_of_commands_is_learnt(latency: float) -> None:
    faults = [{"link": f"{robot}->world", "latency": latency} for robot in (1, 2, 3)]
    simulation = Simulation(load(SCENARIO, {"faults": faults, "duration": 30.0, "robots": {}}))
    trajectory(simulation)
    l_e = np.abs(simulation.trace.errors()[0])
    assert 1e3 * l_e[2000:].max() <= 0.05
    assert 1e3 * l_e.max() < 10.0


@pytest.mark.parametrize("row", ["A", "L"])
def test_noise_and_a_stuck_robot_cost_what_they_may(row: str) -> None:
    found = np.mean([Cell(row, "on time", "nash", seed).run()["l_e"] for seed in (1000, 1001)])
    assert found <= 1.2 * PROTOTYPE[row].nash[0]
