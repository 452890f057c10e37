"""Laws of the table of controllers: every name has options, a colour of its own, and can be made."""

from typing import Any

import pytest

from agents.controllers.registry import MAKES, TEAMS
from formation.errors import ScenarioError
from formation.scenario.controllers import SHARED_KEYS
from formation.scenario.files import load
from formation.scenario.registry import CONTROLLERS, IN_PROCESS, live
from world.run_control import with_controller


def test_every_controller_has_a_line_in_both_tables() -> None:
    assert set(MAKES) == set(live())
    assert set(TEAMS) == set(IN_PROCESS)


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
