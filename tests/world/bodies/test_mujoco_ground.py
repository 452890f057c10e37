"""Laws of the bodies that MuJoCo moves."""

import sys

import numpy as np
import pytest

from formation.errors import ScenarioError
from formation.scenario.files import load
from runtime.inprocess import Simulation, simulate
from tests.exceptions import needs
from world.bodies.mujoco_ground import MujocoGround

DT = 0.01


@pytest.fixture(autouse=True)
def mujoco() -> None:
    needs("mujoco")


def test_a_formation_is_held_on_the_floor_as_on_the_plane_and_twice_alike() -> None:
    scenario = load("triangle-circle", {"bodies": "mujoco:epuck", "duration": 6})
    assert (scenario.bodies.implementation, scenario.bodies.preset) == ("mujoco", "epuck")
    found = [Simulation(scenario).simulate() for _ in range(2)]
    assert found[0].poses.tobytes() == found[1].poses.tobytes()
    plane = Simulation(load("triangle-circle", {"bodies": "epuck", "duration": 6})).simulate()
    assert found[0].poses.tobytes() != plane.poses.tobytes()
    assert np.abs(found[0].errors()[0][-100:]).max() < 3e-3


def test_a_robot_drives_and_turns_as_its_wheels_do_within_a_hundredth() -> None:
    ground = MujocoGround(load("triangle-circle"))
    for _ in range(100):
        before = ground.roll([(0.1, 0.5)] * 3, None, DT)
    after = ground.roll([(0.1, 0.5)] * 3, None, DT)
    assert np.hypot(*(after - before)[:, :2].T) / DT == pytest.approx(0.1, rel=0.01)
    assert (after - before)[:, 2] / DT == pytest.approx(0.5, rel=0.01)


def test_what_carries_a_robot_adds_to_its_motion() -> None:
    alone, pushed = (MujocoGround(load("triangle-circle")) for _ in range(2))
    carried = np.array([[0.01, -0.02, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.5]])
    still = [(0.0, 0.0)] * 3
    for _ in range(100):
        a, b = alone.roll(still, None, DT), pushed.roll(still, carried, DT)
    assert (b - a)[0, :2] == pytest.approx([0.01, -0.02], abs=1e-3)
    assert (b - a)[1] == pytest.approx(np.zeros(3), abs=1e-4)  # one solver for all: not to the last bit
    assert (b - a)[2, 2] == pytest.approx(0.5, abs=0.02)


def test_bodies_do_not_pass_through_each_other() -> None:
    """Two robots head on: where unicycles would change places, these push and stay a diameter apart."""
    poses = [(0.0, 0.0, 0.0), (0.2, 0.0, np.pi), (0.0, 1.0, 0.0)]
    ground = MujocoGround(load("triangle-circle", {"robots": {"poses": poses}}))
    nearest = 1.0
    for _ in range(400):
        found = ground.roll([(0.05, 0.0), (0.05, 0.0), (0.0, 0.0)], None, DT)
        nearest = min(nearest, float(np.hypot(*(found[0] - found[1])[:2])))
    assert 0.066 < nearest < 0.071


def test_without_mujoco_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ScenarioError, match=r"bodies.implementation: .*pip install"):
        simulate(load("triangle-circle", {"bodies": "mujoco:epuck", "duration": 0.1}))
