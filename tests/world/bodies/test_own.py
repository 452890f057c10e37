"""Laws of bodies of users' own: they move the robots, and what is wrong with one is one line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formation.errors import ScenarioError
from formation.scenario.files import load
from runtime.inprocess import Simulation
from tests.user_code import clean
from world.bodies.own import load_bodies

__all__ = ["clean"]
BODY = """\
import numpy as np

class Puck:
    def __init__(self, scenario):
        self.dt, self.poses = scenario.control_interval, np.array(scenario.start_poses())

    def measure(self):
        return self.poses

    def move(self, inputs):
        theta = self.poses[:, 2]
        v, omega = inputs.T
        step = np.stack([v * np.cos(theta), v * np.sin(theta), omega], axis=1)
        self.poses = self.poses + self.dt * step
        {mistake}
"""


def puck(folder: Path, mistake: str = "pass") -> str:
    """The name under which the bodies are loaded."""
    (folder / "puck.py").write_text(BODY.format(mistake=mistake))
    return load_bodies(f"{folder}/puck.py:Puck").name


def simulation(name: str) -> Simulation:
    return Simulation(load("triangle-circle", {"bodies": {"implementation": name}, "duration": 3, "robots": {}}))


def test_they_move_the_robots(tmp_path: Path, clean: None) -> None:
    own = simulation(puck(tmp_path))
    distance, _, _ = own.simulate().errors()
    assert np.abs(distance[-1]).max() < 1e-3
    assert own.trace.poses[-1].any()
    assert [code["origin"] for code in own.world.summary()["user_code"]] == ["puck.py:Puck"]


@pytest.mark.parametrize(
    ("mistake", "line"),
    [
        ("1 / 0", r"bodies Puck: ZeroDivisionError: division by zero \(puck.py:15\)"),
        ("self.poses = self.poses[:2]", r"bodies Puck: expected poses of shape \(3, 3\)"),
        ("self.poses = self.poses + 0.1j", "bodies Puck: expected real poses; got complex numbers"),
        ("self.poses[0, 0] = np.nan", "bodies Puck: expected finite poses of shape"),
    ],
)
def test_a_mistake_ends_the_episode_with_one_line(mistake: Any, line: Any, tmp_path: Path, clean: None) -> None:
    own = simulation(puck(tmp_path, mistake))
    with pytest.raises(ScenarioError, match=line) as raised:
        own.simulate()
    assert "\n" not in str(raised.value)


def test_a_class_that_is_no_body_is_refused(tmp_path: Path, clean: None) -> None:
    (tmp_path / "puck.py").write_text(
        "class Puck:\n    def move(self): ...\nclass wheeled(Puck):\n    measure = Puck.move\n"
    )
    with pytest.raises(ScenarioError, match=r"expected poses, measure\(\) and move\(inputs\); it has move"):
        load_bodies(f"{tmp_path}/puck.py:Puck")
    with pytest.raises(ScenarioError, match="got wheeled, which is built in"):
        load_bodies(f"{tmp_path}/puck.py:wheeled")
