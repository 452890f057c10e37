"""Laws of the room for robots: two in one place are refused whoever puts them there; less than they need is told."""

import pytest

from cli.options import warn
from formation.errors import ScenarioError
from formation.scenario.files import load
from network.interventions import Reshape
from world.world import World

HERE = "robots.poses=[[0.8, 0, 1.57], [0.7, 0, 1.57], [0.8, 0.0001, 1.57]]"


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (
            [HERE],
            "robots.poses: expected a place for each robot; got robots 1 and 3 0.0001 m apart, and they",
        ),
        (["formation.spacing=1e-9"], "formation: expected a place for each robot; got robots 1 and 2 1e-09 m apart"),
        (
            ["formation.changes=[{at=1, shape='triangle', spacing=1e-9}]"],
            r"formation.changes\[0\]: expected a place for each robot; got two robots 1e-09 m apart",
        ),
        (
            ["bodies.radius=0.5", "formation.spacing=0.009", "robots.poses=[[0, 0, 0], [1, 0, 0], [2, 0, 0]]"],
            "formation: expected a place for each robot; got robots 1 and 2 0.009 m apart, and they are 1 m wide",
        ),
        (["robots.poses=[[0, 0, 0]]"], "robots.poses: expected 3 poses for this formation; got 1"),
    ],
)
def test_robots_in_one_place_are_refused_with_both_numbers(settings: list[str], line: str) -> None:
    with pytest.raises(ScenarioError, match=line) as caught:
        load("triangle-circle", settings)
    assert "\n" not in str(caught.value)


def test_users_who_order_such_a_shape_are_refused_likewise() -> None:
    world = World(load("triangle-circle"))
    with pytest.raises(ScenarioError, match="expected a place for each robot; got two robots 1e-09 m apart"):
        world.intervene(Reshape(shape="line", spacing=1e-9))


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (["formation.spacing=0.05"], "formation has robots 1 and 2 0.05 m apart, and they are 0.07 m wide: they touch"),
        (
            ["robots.poses=[[0.8, 0, 1.57], [0.7, 0, 1.57], [0.8, 0.03, 1.57]]"],
            "robots.poses has robots 1 and 3 0.03 m apart, and they are 0.07 m wide: they touch",
        ),
        (["formation.spacing=0.07"], ""),
        (["robots.start_noise.position=1"], ""),
        ([HERE, "robots.start_noise.position=0.02"], ""),
    ],
)
def test_less_room_than_robots_need_is_told(settings: list[str], line: str, capsys: pytest.CaptureFixture[str]) -> None:
    warn(load("triangle-circle", settings))
    assert (line in capsys.readouterr().err) if line else "touch" not in capsys.readouterr().err
