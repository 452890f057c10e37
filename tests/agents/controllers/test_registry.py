"""Laws of the table of controllers: every name has options, a colour of its own, and can be made."""

from typing import Any

import pytest

from agents.controllers.registry import controller_for, team_for
from agents.controllers.task import Task
from formation.errors import ScenarioError
from formation.scenario.controllers import SHARED_KEYS
from formation.scenario.files import load
from formation.scenario.registry import CONTROLLERS, IN_PROCESS, live
from world.run_control import with_controller


@pytest.mark.parametrize("name", live())
def test_every_controller_that_runs_as_a_process_can_be_made_for_one_robot(name: str) -> None:
    scenario = load("circle", {"controller": {"name": name}})
    assert callable(controller_for(scenario, 2, Task(scenario, 2)).plan)
    assert team_for(scenario) is None


@pytest.mark.parametrize("name", IN_PROCESS)
def test_every_other_controller_can_be_made_for_all_robots_only(name: str) -> None:
    scenario = load("circle", {"controller": {"name": name}})
    team = team_for(scenario)
    assert team is not None
    assert callable(team.member(2).plan)
    with pytest.raises(ScenarioError, match="inprocess"):
        controller_for(scenario, 2, Task(scenario, 2))


def test_colours_are_distinct() -> None:
    assert len({spec.colour for spec in CONTROLLERS.values()}) == len(CONTROLLERS)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_key_is_accepted_by_its_own_controller_only(name: Any) -> None:
    own = CONTROLLERS[name].options
    assert type(load("circle", {"controller": {"name": name}}).controller) is own
    for other in CONTROLLERS.values():
        for key in other.options.model_fields:
            if key not in own.model_fields:
                with pytest.raises(ScenarioError, match=rf"controller.{key}: unknown key.*key of .*{other.name}"):
                    load("circle", {"controller": {"name": name, key: 1}})


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_key_is_described(name: Any) -> None:
    fields = CONTROLLERS[name].options.model_fields
    assert all(field.description for key, field in fields.items() if key != "name")
    assert fields["name"].description or CONTROLLERS[name].options.__doc__


def test_another_controller_keeps_what_fits_every_controller() -> None:
    before = load("circle", {"controller": {"own_weight": 50.0, "horizon": 10, "plan_every": 2}})
    after = with_controller(before, "paper").controller
    assert after.model_fields_set & {*SHARED_KEYS} == {"horizon", "plan_every"}
    assert (after.name, after.horizon, after.plan_every) == ("paper", 10, 2)
