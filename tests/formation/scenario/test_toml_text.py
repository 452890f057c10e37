"""The text of a scenario is the scenario."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.scenario.files import load, parse, shipped
from formation.scenario.toml_text import as_toml


@pytest.mark.parametrize("name", shipped())
def test_what_is_written_is_read_again(name: str) -> None:
    scenario = load(name)
    assert parse(tomllib.loads(as_toml(scenario))) == scenario


@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=40), st.floats(0.1, 1e3))
def test_any_text_and_number_survives(text: str, spacing: float) -> None:
    faults = [{"link": "all", "at": 1.0, "latency": 0.2}]
    scenario = load("triangle-circle", {"source": text, "formation": {"spacing": spacing}, "faults": faults})
    again = parse(tomllib.loads(as_toml(scenario)))
    assert (again.source, again.formation, again.faults) == (scenario.source, scenario.formation, scenario.faults)
