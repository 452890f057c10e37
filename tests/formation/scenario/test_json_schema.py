"""The JSON schema of scenario files accepts what the program accepts, and marks the mistakes that an editor can see."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.errors import ScenarioError
from formation.paths.kinds import Circle
from formation.scenario.files import SHIPPED, parse, shipped
from formation.scenario.json_schema import json_schema
from formation.scenario.keys import keys
from formation.scenario.overrides import at_path, merged
from formation.scenario.registry import CONTROLLERS
from formation.scenario.scenario import Scenario
from tests import strategies
from tests.json_schema import accepts

SCHEMA = json_schema()
CASES = Path(__file__).parents[2] / "cases"
SMALL: dict[str, Any] = {"name": "small", "path": {"kind": "circle"}, "formation": {"shape": "triangle"}}
FILES = [*(SHIPPED / f"{name}.toml" for name in shipped()), *CASES.glob("*.toml")]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_files_that_there_are_fit(file: Any) -> None:
    assert accepts(SCHEMA, tomllib.loads(file.read_text("utf-8"))) == (file.stem != "three-columns")


@pytest.mark.parametrize(
    "more",
    [
        {"duration": "2min", "link": {"latency": "300ms", "loss": "30%"}},
        {"bodies": "camera"},
        {"bodies": {"preset": "camera", "lag": "0.1 s"}},
        {"controller": {"horizon": 10}},
        {"controller": {"name": "paper", "errata": [1, 4]}},
        {"path": {"kind": "waypoints", "file": "way.csv", "columns": ["x", 1], "speed_column": 2}},
        {"formation": {"file": "places.csv", "unit": "cm"}},
        {"faults": [{"at": 1, "until": "1min", "link": "1->2", "preset": "wifi", "cut": True}]},
        {"estimator": {"delay": "learn", "lag": 0.1}},
    ],
)
def test_every_way_to_write_a_value_fits(more: Any) -> None:
    assert accepts(SCHEMA, {**SMALL, **more})


@pytest.mark.parametrize(
    "more",
    [
        {"duraton": 60},
        {"duration": 0},
        {"duration": "long"},
        {"link": {"loss": 2}},
        {"link": {"loss": "many"}},
        {"bodies": "camra"},
        {"path": {"kind": "circel"}},
        {"path": {"kind": "waypoints", "points": [[0, 0]]}},
        {"path": {"kind": "circle", "scale": 1}},
        {"controller": {"name": "nash", "gains": [1, 1]}},
        {"formation": {"shape": "blob"}},
        {"faults": [{"preset": "wify"}]},
        {"seed": -1},
    ],
)
def test_a_mistake_that_an_editor_can_see_is_marked_as_the_program_refuses_it(more: Any) -> None:
    assert not accepts(SCHEMA, {**SMALL, **more})
    with pytest.raises(ScenarioError):
        parse({**SMALL, **more})


DRAWN = st.fixed_dictionaries(
    {"path": strategies.of(Circle)},
    optional={
        name: strategies.of(Scenario.model_fields[name].annotation)
        for name in ("noise", "link", "faults", "disturbances", "estimator", "lockstep")
    }
    | {"controller": st.one_of([strategies.of(spec.options) for spec in CONTROLLERS.values()])},
)


@given(DRAWN)
@settings(max_examples=60)
def test_whatever_a_scenario_can_hold_fits(tables: Any) -> None:
    plain = {
        name: [one.model_dump(mode="json", exclude_unset=True) for one in value]
        if isinstance(value, tuple)
        else value.model_dump(mode="json", exclude_unset=True)
        for name, value in tables.items()
    }
    assert accepts(SCHEMA, json.loads(json.dumps({**SMALL, **plain})))


NUMBERS = [key for key in keys() if key.type.startswith(("number", "whole")) and "[]" not in key.path and not key.of]


@given(st.sampled_from(NUMBERS), st.floats(-3, 3) | st.integers(-200, 200) | st.sampled_from([1e30, 0.5]))
@settings(max_examples=300)
def test_a_number_that_the_schema_refuses_is_refused_by_the_program_with_its_key(key: Any, value: Any) -> None:
    raw = merged(SMALL, at_path(key.path, value))
    if accepts(SCHEMA, raw):
        return
    with pytest.raises(ScenarioError) as caught:
        parse(raw)
    assert key.path in str(caught.value)
