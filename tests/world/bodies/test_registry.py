"""Laws of every implementation of bodies."""

from typing import Any

import numpy as np
import pytest

from formation.errors import ScenarioError
from formation.scenario.files import load
from world.bodies.registry import IMPLEMENTATIONS, bodies_for

NOISY = {"slip": 0.1, "gyro": 0.1, "localisation": {"position": 0.01, "heading": 0.01}}


@pytest.mark.parametrize("name", IMPLEMENTATIONS)
def test_bodies_start_where_the_scenario_puts_them_and_repeat_themselves(name: Any) -> None:
    scenario = load("triangle-circle", {"bodies": {**NOISY, "implementation": name}})
    one, other = bodies_for(scenario), bodies_for(scenario)
    np.testing.assert_array_equal(one.poses, scenario.start_poses())
    for _ in range(20):
        seen, again = one.measure(), other.measure()
        assert seen is not None
        assert again is not None
        np.testing.assert_array_equal(seen.poses, again.poses)
        for bodies in (one, other):
            bodies.move(np.full((scenario.size, 2), 0.2))
    np.testing.assert_array_equal(one.poses, other.poses)
    assert not one.poses.flags.writeable


def test_unknown_bodies_are_refused_with_the_choices() -> None:
    with pytest.raises(ScenarioError, match="expected one of wheeled"):
        bodies_for(load("circle", {"bodies": {"implementation": "weeled"}}))
