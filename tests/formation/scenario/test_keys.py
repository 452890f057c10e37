"""The list of keys is complete, and what it says of a key is so."""

import json
import types
from typing import Annotated, Any, Union, get_args, get_origin

import pytest
from pydantic import BaseModel

from formation.scenario.controllers import ControllerOptions
from formation.scenario.files import parse
from formation.scenario.keys import ABSENT, REQUIRED, keys, matching
from formation.scenario.registry import CONTROLLERS
from formation.scenario.scenario import Scenario
from formation.validation import TAGS

KEYS = keys()
SMALL: dict[str, Any] = {"name": "small", "path": {"kind": "circle"}, "formation": {"shape": "triangle"}}


def models(annotation: Any) -> list[type[BaseModel]]:
    if annotation is ControllerOptions:  # stands for any of them
        return [spec.options for spec in CONTROLLERS.values()]
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) in (Union, types.UnionType, Annotated, list, tuple):
        return [model for part in get_args(annotation) for model in models(part)]
    return []


def fields(model: type[BaseModel], above: str = "") -> set[str]:
    """Paths of every field of a model and of those in it."""
    found = set()
    for name, field in model.model_fields.items():
        path = f"{above}{name}"
        found.add(path)
        many = "[]." if get_origin(field.annotation) in (list, tuple) else "."
        for inner in models(field.annotation):
            found |= fields(inner, path + many)
    return found


def test_every_key_of_the_schema_is_listed_and_no_other() -> None:
    assert {key.path for key in KEYS} == fields(Scenario)


@pytest.mark.parametrize("key", KEYS, ids=lambda key: "-".join([key.path, *key.of]))
def test_every_key_is_described_and_every_number_has_a_unit(key: Any) -> None:
    assert key.text.strip()
    if key.type.startswith("number"):
        assert key.unit


def test_a_key_is_listed_once_for_each_table_that_means_something_else_by_it() -> None:
    seen = [(key.path, of) for key in KEYS for of in key.of or ("",)]
    assert len(set(seen)) == len(seen)
    assert {of for key in KEYS if key.path == "controller.errata" for of in key.of} == {"paper", "leader_follower"}


def test_defaults_are_those_of_a_scenario_that_leaves_them_out() -> None:
    whole = parse(SMALL).model_dump(mode="json")
    checked = 0
    for key in KEYS:
        top, *rest = key.path.split(".")
        if "[]" in key.path or key.type.startswith("table") or top == "path" or key.path == "formation.shape":
            continue
        if key.of and whole[top].get("name") not in key.of:
            continue
        value = whole[top]
        for part in rest:
            value = value if value is None else value[part]
        if value is None and key.path.startswith("bodies.limits."):
            continue  # the whole table is absent
        if key.default == REQUIRED:
            assert key.path == "name"
        else:
            assert (None if key.default == ABSENT else json.loads(key.default)) == value, key
        checked += 1
    assert checked > 60


def test_a_word_finds_the_keys_that_have_it() -> None:
    found = {key.path for key in matching("latency")}
    assert found == {"link.latency", "faults[].latency"}
    assert matching("nothing like it") == []


def test_a_tag_lists_what_it_may_be() -> None:
    tags = {key.path: key.range.split(", ") for key in KEYS if key.type.startswith("choice of")}
    assert set(tags) == {"path.kind", "controller.name"}
    assert {path.rpartition(".")[2] for path in tags} == set(TAGS)
    assert "waypoints" in tags["path.kind"]
    assert "nash" in tags["controller.name"]
