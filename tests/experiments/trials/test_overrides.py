"""Laws of overrides as nested data."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from experiments.trials.overrides import at_path, merged, paths

keys = st.text("abc", min_size=1, max_size=2)
tables = st.recursive(
    st.dictionaries(keys, st.integers(), max_size=3), lambda inner: st.dictionaries(keys, inner, max_size=3)
)


@given(tables)
def test_nothing_is_changed_by_nothing_and_by_itself(table: Any) -> None:
    assert merged(table) == merged(table, {}) == merged(table, table) == merged({}, table) == table


@given(tables, tables)
def test_every_key_of_an_override_is_set(table: Any, overrides: Any) -> None:
    result = merged(table, overrides)
    for path in paths(overrides):
        found, wanted = result, overrides
        for key in path.split("."):
            found, wanted = found[key], wanted[key]
        assert found == wanted


@given(tables, tables, tables)
def test_overrides_in_a_row_are_overrides_at_once(table: Any, first: Any, second: Any) -> None:
    assert merged(merged(table, first), second) == merged(table, first, second)


def test_arguments_are_left_as_they_were() -> None:
    table: dict[str, Any] = {"link": {"latency": 0.0}, "faults": [{"at": 1}]}
    result = merged(table, {"link": {"loss": 0.5}})
    result["faults"][0]["at"] = 2
    assert table == {"link": {"latency": 0.0}, "faults": [{"at": 1}]}
    assert result["link"] == {"latency": 0.0, "loss": 0.5}


def test_an_empty_table_empties_and_a_path_of_another_kind_replaces() -> None:
    table = {"robots": {"poses": [1]}, "path": {"kind": "circle", "radius": 0.8}}
    assert merged(table, {"robots": {}})["robots"] == {}
    assert merged(table, {"path": {"kind": "sinusoid"}})["path"] == {"kind": "sinusoid"}
    assert merged(table, {"path": {"kind": "circle", "rate": 1}})["path"] == {
        "kind": "circle",
        "radius": 0.8,
        "rate": 1,
    }


@given(st.lists(keys, min_size=1, max_size=4), st.text())
def test_a_value_at_a_path_is_found_at_that_path_as_it_is(names: Any, value: Any) -> None:
    path = ".".join(names)
    table: Any = at_path(path, value)
    assert list(paths(table)) == [path]
    for name in names:
        table = table[name]
    assert table == value
