"""Laws of waiting for the lost: nobody drives on without a robot that is not told the path any more."""

from typing import Any

import numpy as np
import pytest

from formation.errors import ScenarioError
from formation.scenario.files import load, parse
from formation.scenario.scenario import Scenario
from runtime import inprocess
from runtime.inprocess import Simulation
from tests.memory_run import MemoryRun

CUT = {"link": "1->2", "cut": True, "at": 2.0}


def lost(wait: bool, until: float, **changes: Any) -> Scenario:
    path, fault = {"wait_for_lost": wait}, {**CUT, "until": until}
    given = {"bodies": {"preset": "ideal"}, "path": path, "faults": [fault], "duration": until + 8.0, **changes}
    return load("follow-the-leader", given)


def largest(simulation: Simulation) -> float:
    """Of all |l_e| [m]."""
    return float(np.abs(simulation.simulate().errors()[0]).max())


@pytest.mark.parametrize("until", [8.0, 16.0], ids=["for a while", "beyond what a reference keeps"])
def test_a_formation_that_waits_for_the_lost_stays_together_and_goes_on_when_they_are_told_again(until: float) -> None:
    waiting = Simulation(lost(True, until, duration=2.0 * until + 2.0))
    assert largest(waiting) < 3e-3
    lags = [agent._task.lag for agent in waiting.agents.values()]
    assert max(lags) < 0.1
    assert waiting.trace.errors()[2][-1] < 2e-3


def test_one_that_does_not_wait_drives_on_and_is_apart() -> None:
    assert largest(Simulation(lost(False, 8.0))) > 0.05


def test_a_lost_robot_that_nobody_waits_for_declares_no_need() -> None:
    simulation = Simulation(lost(False, 8.0))
    while simulation.world.now < 7.5:
        simulation.step()
    plan = simulation.agents[2]._sending.last
    assert plan is not None
    assert plan.lost
    assert not plan.waits
    assert plan.news[:, 1].max(initial=0.0) == 0.0


def test_waiting_for_the_lost_is_alike_in_both_engines() -> None:
    scenario = lost(True, 4.8, duration=5.5)
    assert MemoryRun(scenario).finish() == inprocess.simulate(scenario)["trajectory_sha256"]


@pytest.mark.parametrize(
    "changes",
    [
        {"path": {"known_to": "all", "wait_for_lost": True}},
        {"path": {"wait_for_lost": True}, "controller": {"name": "consensus"}},
    ],
    ids=["nobody can be lost", "a controller that does not wait"],
)
def test_waiting_for_the_lost_is_refused_where_it_means_nothing(changes: Any) -> None:
    with pytest.raises(ScenarioError, match="wait_for_lost: expected"):
        load("follow-the-leader", changes)


def test_a_driver_is_not_waited_for() -> None:
    raw = {"name": "t", "path": {"kind": "driven", "wait_for_lost": True}, "formation": {"shape": "square"}}
    with pytest.raises(ScenarioError, match="not driven"):
        parse(raw)
