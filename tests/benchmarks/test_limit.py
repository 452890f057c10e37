"""Laws of the joint linear law, the bound on what messages can buy."""

import numpy as np
import pytest

from benchmarks.limit import Joint, JointTeam, Weights
from formation.scenario.files import load
from runtime.inprocess import Simulation

WEIGHTS = Weights(1e-2, 3e-5, 0.1)


def test_the_joint_law_brings_every_error_back() -> None:
    """On ideal bodies, from the shipped start 7 to 50 mm off."""
    scenario = load("triangle-circle", {"duration": 20})
    trace = Simulation(scenario, team=JointTeam(scenario, WEIGHTS)).simulate()
    distance, _, centre = trace.errors()
    assert np.abs(distance[0]).max() > 5e-3
    assert np.abs(distance[-1]).max() < 1e-4
    assert centre[-1] < 1e-4


def test_its_errors_along_answer_for_the_neighbours_as_well() -> None:
    """An error of one robot moves the others too: that is what separates it from laws without messages."""
    gain = Joint(load("triangle-circle"), WEIGHTS).gain
    assert gain.shape == (6, 9)
    assert np.abs(gain[2, 0:2]).max() > 0.05 * abs(gain[2, 3])


def test_a_formation_that_is_no_rigid_body_is_refused() -> None:
    with pytest.raises(SystemExit, match="rigid body"):
        Joint(load("figure8"), WEIGHTS)
