"""Laws of event-triggered sending."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from agents.kernels.drifting import age_drifting
from agents.sending import QUIET
from formation.scenario.files import load
from network.messages import Plan
from runtime.inprocess import Simulation

NOISE = {"slip": 0.2, "gyro": 0.2, "position": 0.001, "heading": 0.01}


def plans(scenario: str, changes: dict[str, Any]) -> tuple[list[Plan], Simulation]:
    """Every plan that robot 2 sends, and the episode."""
    simulation = Simulation(load(scenario, {"duration": 8, **changes}))
    found: list[Plan] = []
    while not simulation.finished:
        simulation.step()
        found += [plan for plan in simulation.plans if plan.sender == 2]
    return found, simulation


def test_without_a_tolerance_every_plan_goes_out_numbered() -> None:
    found, simulation = plans("triangle-circle", {"controller": {"plan_every": 2}})
    assert [plan.number for plan in found] == list(range(simulation.world.k // 2))
    assert [plan.seq for plan in found] == [2 * plan.number for plan in found]


def test_a_robot_that_does_as_it_said_is_silent_for_half_a_second_at_a_time() -> None:
    found, _ = plans("triangle-circle", {"controller": {"send_when": 0.002}})
    settled = [plan for plan in found if plan.stamp > 4.0]
    assert {round(b.stamp - a.stamp, 2) for a, b in pairwise(settled)} == {QUIET}
    assert [plan.number for plan in found] == list(range(len(found)))  # what was kept back is no loss


def test_a_smaller_tolerance_sends_more() -> None:
    sent = []
    for tolerance in (0.0005, 0.001, 0.008):
        found, _ = plans("triangle-circle", {"noise": NOISE, "controller": {"send_when": tolerance, "plan_every": 2}})
        sent.append(len(found))
    assert sent[0] > 1.5 * sent[1] > 2.0 * sent[2]


def test_a_receiver_is_never_wrong_by_more_than_the_tolerance_at_a_plan() -> None:
    """What the receiver of a perfect link believes, against the estimate that the sender had: plan by plan."""
    simulation = Simulation(load("triangle-circle", {"noise": NOISE, "controller": {"send_when": 0.002}}))
    worst = 0.0
    while simulation.world.now < 6.0:
        simulation.step()
        k, now = simulation.world.k - 1, simulation.world.now - simulation.world.scenario.control_interval
        own = simulation.agents[2]._last
        sent = simulation.agents[2]._sending.last
        assert own is not None
        assert sent is not None
        if own[0] == k:
            forecast = np.empty(3)
            age_drifting(sent.pose, sent.inputs, sent.drift, now - sent.stamp, sent.interval, forecast)
            worst = max(worst, float(np.hypot(*(own[2] - forecast)[:2])))
    assert 0.001 < worst <= 0.002


def test_while_somebody_waits_every_plan_goes_out() -> None:
    stuck = {"disturbances": [{"robot": 2, "at": 2.0, "until": 5.0, "drive": 0.0}]}
    found, simulation = plans("triangle-circle", {**stuck, "controller": {"send_when": 0.01}, "noise": NOISE})
    stamps = [plan.stamp for plan in found if 3.5 < plan.stamp < 5.0]
    assert len(stamps) == pytest.approx(1.5 / simulation.world.scenario.control_interval, abs=2)
