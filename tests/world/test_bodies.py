"""Laws of every implementation of bodies."""

from typing import Any

import numpy as np
import pytest

from formation.errors import ScenarioError
from formation.scenario.files import load
from world.bodies.registry import IMPLEMENTATIONS, bodies_for


@pytest.mark.parametrize("name", IMPLEMENTATIONS)
def test_bodies_start_where_the_scenario_puts_them_and_repeat_themselves(name: Any) -> None:
    scenario = load("triangle-circle", {"noise": {"slip": 0.1, "position": 0.01}})
    one, other = bodies_for(scenario, name), bodies_for(scenario, name)
    np.testing.assert_array_equal(one.poses, scenario.start_poses())
    for _ in range(20):
        np.testing.assert_array_equal(one.measure(), other.measure())
        for bodies in (one, other):
            bodies.move(np.full((scenario.size, 2), 0.2))
    np.testing.assert_array_equal(one.poses, other.poses)
    assert not one.poses.flags.writeable


def test_unknown_bodies_are_refused_with_the_choices() -> None:
    with pytest.raises(ScenarioError, match="expected one of unicycle"):
        bodies_for(load("circle"), "unicicle")
