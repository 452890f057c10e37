"""Presets of bodies: which value wins, and formations that fit the robots."""

import numpy as np
import pytest

from formation.bodies.presets import PRESETS
from formation.errors import ScenarioError
from formation.metrics import nearest
from formation.paths.kinds import Circle, Corner, Figure8, Line, Sinusoid, Spiral
from formation.paths.path import Path
from formation.paths.waypoints import Waypoints
from formation.scenario.files import load, parse, shipped
from formation.scenario.fitting import APART, factor
from formation.scenario.scenario import Scenario

ROBOTS = [name for name, keys in PRESETS.items() if "radius" in keys]
SCENARIO = "triangle-circle"


def test_four_robots_that_one_can_buy_have_a_preset_with_limits_and_a_size() -> None:
    assert {"turtlebot3", "epuck", "robotarium", "duckiebot"} == set(ROBOTS)
    assert all(set(PRESETS[name]["limits"]) == {"v", "omega"} for name in ROBOTS)


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_a_preset_is_a_scenario_by_its_name_alone(name: str) -> None:
    assert load(SCENARIO, {"bodies": name}).bodies == load(SCENARIO, {"bodies": {"preset": name}}).bodies


def test_an_explicit_key_wins_over_the_preset_and_the_preset_over_the_default() -> None:
    bodies = load(SCENARIO, {"bodies": {"preset": "camera", "lag": 0.3, "localisation": {"age": 0.2}}}).bodies
    camera = PRESETS["camera"]
    assert (bodies.lag, bodies.localisation.age) == (0.3, 0.2)
    assert (bodies.delay, bodies.localisation.rate) == (camera["delay"], camera["localisation"]["rate"])
    assert bodies.slip_time == 0.0


def test_a_setting_wins_over_the_file() -> None:
    raw = {"path": {"kind": "circle"}, "name": "x", "formation": {"shape": "triangle"}, "bodies": {"lag": 0.1}}
    assert parse(raw, ["bodies.lag=0.2"]).bodies.lag == 0.2
    assert parse(raw, ["bodies.preset=rough"]).bodies.lag == 0.1  # the file's own key stays explicit


def test_what_differs_in_one_robot_is_its_own() -> None:
    bodies = load(SCENARIO, {"bodies": {"preset": "mocap", "robots": [{"robot": 2, "lag": 0.4}]}}).bodies
    assert [(entry.robot, entry.lag, entry.scale) for entry in bodies.robots] == [(2, 0.4, None)]
    with pytest.raises(ScenarioError, match="at most one entry a robot"):
        load(SCENARIO, {"bodies": {"robots": [{"robot": 2, "lag": 0.4}, {"robot": 2, "lag": 0.1}]}})


def test_noise_is_another_spelling_and_refused_where_it_says_the_same_twice() -> None:
    scenario = load(SCENARIO, {"noise": {"slip": 0.1, "position": 0.002}, "bodies": {"lag": 0.1}})
    assert (scenario.body.slip, scenario.body.localisation.position, scenario.body.lag) == (0.1, 0.002, 0.1)
    with pytest.raises(ScenarioError, match="either here or in bodies"):
        load(SCENARIO, {"noise": {"slip": 0.1}, "bodies": {"slip": 0.1}})
    with pytest.raises(ScenarioError, match="either here or in bodies"):
        load(SCENARIO, {"noise": {"heading": 0.1}, "bodies": "camera"})


@pytest.mark.parametrize("name", ROBOTS)
def test_limits_are_the_robots_unless_the_scenario_gives_them(name: str) -> None:
    limits = PRESETS[name]["limits"]
    of = load(SCENARIO, {"bodies": name}).robots.limits
    assert (of.v, of.omega) == (limits["v"], limits["omega"])
    of = load(SCENARIO, {"bodies": name, "robots": {"limits": {"v": 0.3}}}).robots.limits
    assert (of.v, of.omega) == (0.3, limits["omega"])
    of = load(SCENARIO, {"bodies": {"preset": name, "limits": {"v": 0.3, "omega": 1.0}}}).robots.limits
    assert (of.v, of.omega) == (0.3, 1.0)


def apart(scenario: Scenario) -> float:
    return min(nearest(shape)[2] for shape in scenario.formation.shapes)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("scenario", shipped())
def test_every_shipped_scenario_fits_every_robot(scenario: str, name: str) -> None:
    fitted, before = load(scenario, {"bodies": name}), load(scenario)
    assert apart(fitted) >= 2.0 * fitted.bodies.radius * APART - 1e-9
    assert apart(fitted) == pytest.approx(fitted.bodies.scaled * apart(before))
    times = np.linspace(0.0, 30.0, 7)
    np.testing.assert_allclose(
        fitted.path.position(times), fitted.bodies.scaled * before.path.position(times), rtol=1e-9, atol=1e-9
    )
    if before.robots.poses is not None:
        assert fitted.robots.poses is not None
        starts, places = np.array(fitted.robots.poses), np.array(before.robots.poses)
        np.testing.assert_allclose(starts, places * [fitted.bodies.scaled, fitted.bodies.scaled, 1.0])
    assert factor(fitted) == 1.0


def test_what_is_scaled_stays_as_it_is_when_it_is_read_again() -> None:
    fitted = load(SCENARIO, {"bodies": "turtlebot3"})
    again = Scenario.model_validate_json(fitted.model_dump_json(exclude_unset=True))
    assert fitted.bodies.scaled > 1.0
    assert again == fitted
    assert parse(fitted.model_dump(exclude_unset=True)) == fitted


def test_shapes_that_follow_are_scaled_too() -> None:
    changes = [{"at": 10.0, "shape": "line"}, {"at": 30.0, "offsets": [[0.2, 0.0], [0.0, 0.1], [0.0, -0.1]]}]
    before = load(SCENARIO, {"formation": {"changes": changes}})
    fitted = load(SCENARIO, {"formation": {"changes": changes}, "bodies": "duckiebot"})
    for one, other in zip(fitted.formation.shapes, before.formation.shapes, strict=True):
        np.testing.assert_allclose(one, fitted.bodies.scaled * other, atol=1e-12)


def test_who_does_not_want_another_scale_gets_a_refusal() -> None:
    with pytest.raises(ScenarioError, match=r"expected a formation for robots 0\.21 m wide"):
        load(SCENARIO, {"bodies": {"preset": "turtlebot3", "fit": "refuse"}})
    assert load(SCENARIO, {"bodies": {"preset": "epuck", "fit": "refuse"}}).bodies.scaled == 1.0


@pytest.mark.parametrize("kind", [Circle, Corner, Figure8, Line, Sinusoid, Spiral, Waypoints])
def test_lengths_of_a_path_are_keys_of_it(kind: type[Path]) -> None:
    assert kind.lengths
    assert set(kind.lengths) <= set(kind.model_fields)
