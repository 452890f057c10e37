"""Laws of overrides: a value is the same wherever it was written, and on the way to every process."""

import tomllib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.errors import ScenarioError
from formation.scenario.files import load
from formation.scenario.overrides import at_path, from_json, from_settings, merged, paths, to_json

KEYS = st.text(st.characters(categories=("L", "N")), min_size=1, max_size=5)
LEAVES = (
    st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.text(st.characters(codec="utf-8"), max_size=12)
)
VALUES = st.recursive(
    LEAVES, lambda part: st.lists(part, max_size=3) | st.dictionaries(KEYS, part, max_size=3), max_leaves=6
)
TABLES = st.dictionaries(KEYS, VALUES, max_size=3)


def toml(value: Any) -> str:
    """The value as TOML has it; strings with every escape that TOML knows."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            return '"' + "".join(f"\\U{ord(letter):08X}" if not letter.isalnum() else letter for letter in value) + '"'
        case list():
            return "[" + ", ".join(map(toml, value)) + "]"
        case dict():
            return "{" + ", ".join(f"{toml(key)} = {toml(part)}" for key, part in value.items()) + "}"
        case _:
            return repr(value)


@given(VALUES)
def test_any_toml_value_survives_from_set_to_the_process_of_the_world(value: Any) -> None:
    assert tomllib.loads(f"value = {toml(value)}")["value"] == value
    assert from_json(to_json(from_settings([f"some.key={toml(value)}"]))) == at_path("some.key", value)


@pytest.mark.parametrize(
    "text", ['a "quoted" word', "it's", "a = b, c", "$HOME and `pwd`", "line\nbreak", "", "→", "{}"]
)
def test_text_survives_to_the_scenario(text: str) -> None:
    overrides = from_json(to_json(from_settings([f"source={toml(text)}"])))
    assert load("circle", overrides).source == text


def test_what_is_no_toml_is_text() -> None:
    assert from_settings(["link.latency=300ms", "controller.name=nash"]) == {
        "link": {"latency": "300ms"},
        "controller": {"name": "nash"},
    }
    assert from_settings(["source=1\nseed = 2"]) == {"source": "1\nseed = 2"}


@pytest.mark.parametrize("setting", ["", "=1", "seed", "a..b=1", ".a=1", "a.=1"])
def test_a_setting_without_key_and_value_is_refused(setting: str) -> None:
    with pytest.raises(ScenarioError, match="expected key=value"):
        from_settings([setting])


@pytest.mark.parametrize("text", ["", "[]", "1", "{", "null", "[" * 100_000])
def test_what_is_no_json_object_is_refused(text: str) -> None:
    with pytest.raises(ScenarioError, match="expected a JSON object"):
        from_json(text)


@given(TABLES, TABLES)
def test_merging_sets_what_is_named_and_keeps_the_rest(table: dict[str, Any], more: dict[str, Any]) -> None:
    result = merged(table, more)
    assert set(result) == {*table, *more}
    for path in paths(more):
        assert _at(result, path) == _at(more, path)
    assert merged(result, more) == result
    assert merged(table, {}) == table


def _at(table: Any, path: str) -> Any:
    for key in path.split("."):
        table = table[key]
    return table


def test_an_empty_table_and_a_path_of_another_kind_begin_anew() -> None:
    assert load("triangle-circle", {"robots": {}}).robots.poses is None
    assert load("triangle-circle", {"path": {"kind": "sinusoid", "speed": 0.2}}).path.model_fields_set == {
        "kind",
        "speed",
    }
    kept = load("triangle-circle", {"path": {"rate": 0.06}}).path
    assert kept.model_fields_set == {"kind", "radius", "rate"}
