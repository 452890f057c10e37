"""Laws of the scenarios that a page offers: what is chosen is what runs, and the world reads no file for it."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dashboard.page import Page
from dashboard.scenario_list import MAX_FILES, ScenarioList, use_table
from formation.errors import ScenarioError
from formation.scenario.files import load, parse, shipped
from formation.scenario.scenario import Scenario
from network import control
from network.codec import decode, encode
from network.control import UseScenario
from network.requests import Request
from tests.dashboard.fakes import edit
from world.run_control import RunControl, with_controller
from world.world import World

OWN = """\
name = "own"
[path]
kind = "waypoints"
file = "way.csv"
[formation]
file = "places.csv"
[link]
latency = "100ms"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "own.toml").write_text(OWN)
    (tmp_path / "way.csv").write_text("0,0\n1,0.1\n2,0\n")
    (tmp_path / "places.csv").write_text("0.1,0\n0,0.1\n-0.1,-0.1\n")
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "x"\n')
    (tmp_path / "broken.toml").write_text("name = ")
    return tmp_path


def ran(operation: UseScenario) -> Scenario:
    """What a world runs after the operation has come over the wire."""
    world = World(load("circle"))
    sent = decode(Request, encode(control.request(operation)))
    RunControl(world, cast(Any, None), SimpleNamespace(recall=lambda: None), go=True).obey(control.operation(sent))  # type: ignore[arg-type]
    return world.scenario


def test_the_users_own_scenario_comes_first_and_can_be_returned_to(folder: Any) -> None:
    started = load("circle", {"link": {"latency": 0.3}})
    found = ScenarioList(started, folder)
    assert found.labels[0] == "circle (as started)"
    assert ran(found.operation(found.labels[0])) == started
    assert ran(found.operation("circle")) == load("circle")


def test_what_was_started_as_shipped_is_offered_once() -> None:
    assert ScenarioList(load("circle")).labels == tuple(shipped())


def test_scenarios_of_the_folder_are_offered_and_nothing_else_of_it(folder: Any) -> None:
    found = ScenarioList(None, folder)
    assert set(found.labels) - set(shipped()) == {"own.toml"}
    assert ran(found.operation("own.toml")) == load(str(folder / "own.toml"))


def test_the_world_needs_no_file_for_it(folder: Any) -> None:
    own = load(str(folder / "own.toml"))
    for file in folder.iterdir():
        file.unlink()
    assert ran(use_table(own)) == own


def test_a_table_that_names_a_file_is_refused(folder: Any) -> None:
    table = {
        "name": "x",
        "path": {"kind": "waypoints", "file": str(folder / "way.csv")},
        "formation": {"shape": "line"},
    }
    with pytest.raises(ScenarioError, match="only a scenario that is loaded by its name may name files"):
        ran(UseScenario(scenario="x", table=table))


@pytest.mark.parametrize("name", ["own.toml", "/etc/passwd", "../circle", "nothing"])
def test_a_name_that_is_not_shipped_is_refused_by_the_world(folder: Any, name: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(folder)
    with pytest.raises(ScenarioError, match="expected one of circle"):
        ran(UseScenario(scenario=name))


def test_a_file_that_has_changed_is_read_again_and_one_that_is_gone_is_told(folder: Any) -> None:
    found = ScenarioList(None, folder)
    (folder / "more.toml").write_text(OWN.replace("own", "more"))
    (folder / "own.toml").write_text(OWN.replace("100ms", "250ms"))
    found.refresh()
    assert "more.toml" in found.labels
    assert ran(found.operation("own.toml")).link.latency == 0.25
    (folder / "more.toml").unlink()
    with pytest.raises(ScenarioError, match="there is no"):
        found.operation("more.toml")
    found.refresh()
    assert "more.toml" not in found.labels


def test_a_folder_that_is_gone_or_too_full_does_no_harm(folder: Any) -> None:
    for number in range(MAX_FILES + 10):
        (folder / f"a{number:03}.toml").write_text(OWN)
    assert len(ScenarioList(None, folder).labels) == len(shipped()) + MAX_FILES
    assert ScenarioList(None, folder / "none").labels == tuple(shipped())


def test_the_label_is_that_of_what_runs_whichever_controller(folder: Any) -> None:
    started = load(str(folder / "own.toml"))
    found = ScenarioList(started, folder)
    again = parse(started.model_dump(mode="json", exclude_unset=True))
    assert found.label_of(again, "own") == "own (as started)"
    assert found.label_of(with_controller(again, "leader_follower"), "own") == "own (as started)"
    assert found.label_of(load("circle"), "circle") == "circle"
    assert found.label_of(None, "sinusoid") == "sinusoid"


def test_the_page_sends_what_is_chosen_and_tells_what_is_wrong(page: Page, folder: Any, monkeypatch: Any) -> None:
    asked: list[Any] = []
    told: list[Any] = []
    page._scenarios.__init__(None, folder)  # type: ignore[misc]
    monkeypatch.setattr(page._requests, "ask", lambda operation, number: asked.append((operation, number)))
    monkeypatch.setattr(page._requests, "refuse", lambda title, text, number: told.append((text, number)))
    dropdown = page._run._scenario.control
    dropdown.options = page._scenarios.labels

    def choose(label: str) -> None:
        page._run._choose_scenario(edit(label, 3))

    choose("own.toml")
    assert asked == [(use_table(load(str(folder / "own.toml"))), 3)]
    choose("/etc/passwd")
    (folder / "own.toml").write_text(OWN.replace("100ms", "soon"))
    choose("own.toml")
    assert len(asked) == 1
    assert len(told) == 1
    assert "link.latency" in told[0][0]
