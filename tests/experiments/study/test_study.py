"""Study files: every mistake is one line with its key, every shipped study can be simulated."""

# mypy: disable-error-code="no-any-return"

import json
from pathlib import Path
from typing import Any

import pytest

from cli import main as command
from experiments.study import study as studies
from experiments.study.grid import trials
from experiments.study.study import parse
from formation.errors import EchelonError, StudyError

BASE: dict[str, Any] = {
    "name": "small",
    "scenarios": ["triangle-circle"],
    "overrides": {"duration": 1.5},
    "seeds": 2,
    "measures": ["distance_rms_m"],
    "axes": [
        {"name": "controller", "key": "controller.name", "values": ["nash", "leader_follower"]},
        {"name": "latency", "key": "link.latency", "values": [0.0, 0.2, 0.5], "unit": "s"},
    ],
}


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"measures": ["rms"]}, "measures[0]: expected one of distance_rms_m"),
        ({"measures": ["recovery_s"]}, "measures[0]: expected an [event] for recovery_s; got none"),
        ({"seeds": 0}, "seeds: expected at least 1; got 0"),
        ({"speed": 1}, "speed: unknown key: expected one of name, title"),
        ({"scenarios": []}, "scenarios: expected"),
        ({"overrides": ["duration=1"]}, "overrides: expected"),
        ({"settings": ["duration=1"]}, "settings: expected overrides, a table such as overrides = { duration = 60 }"),
        ({"axes": [{"name": "seed", "key": "seed", "values": [1]}]}, "axes[0]: expected another name than seed"),
        ({"axes": [{"name": "a", "key": "seed"}]}, "axes[0]: expected either key and values, or choices"),
        ({"axes": [{"name": "a", "key": "seed", "values": [1, 1]}]}, "axes[0]: expected values that differ"),
        ({"axes": [BASE["axes"][0]] * 2}, "axes[1].name: expected a name of its own; got 'controller' again"),
        ({"baseline": {"latency": 9.0}}, "baseline.latency: expected one of 0.0, 0.2, 0.5; got '9.0'"),
        ({"baseline": {"lateness": 0.0}}, "baseline.lateness: unknown axis: expected one of scenario, controller"),
        ({"event": {"at": 2, "until": 1, "below": 1}}, "event: expected until > at"),
        ({"event": {"at": 1, "until": 2}}, "event: expected either below or factor"),
        ({"warmup": 1, "event": {"at": 1, "until": 2, "factor": 1}}, "event.at: expected more than the warmup of 1 s"),
        ({"figures": [{"name": "f", "kind": "bands", "x": "latency"}]}, "figures[0].value: expected a value for bands"),
        ({"figures": [{"name": "f", "kind": "pie"}]}, "figures[0].kind: expected one of bands, surface, recovery"),
        (
            {"figures": [{"name": "f", "kind": "bands", "x": "late", "value": "distance_rms_m"}]},
            "figures[0].x: expected one of scenario, controller, latency; got 'late' (did you mean latency?)",
        ),
        (
            {"bounds": [{"measure": "distance_max_m", "at_most": 1}]},
            "bounds[0].measure: expected one of distance_rms_m",
        ),
        (
            {"bounds": [{"measure": "distance_rms_m", "statistic": "ratio", "at_most": 1}]},
            "bounds[0].statistic: expected a [baseline] for a ratio; got none",
        ),
    ],
)
def test_a_mistake_is_one_line_with_its_key(changes: Any, line: Any) -> None:
    with pytest.raises(StudyError) as caught:
        parse(BASE | changes, where="file")
    (told,) = str(caught.value).splitlines()
    assert told.startswith(f"file: {line}")


def test_several_mistakes_are_several_lines() -> None:
    with pytest.raises(StudyError) as caught:
        parse(BASE | {"measures": ["rms"], "baseline": {"latency": 9.0}})
    assert len(str(caught.value).splitlines()) == 2


def test_an_override_may_not_replace_an_axis(tmp_path: Any) -> None:
    file = tmp_path / "own.toml"
    file.write_text(
        'name = "own"\nscenarios = ["circle"]\nmeasures = ["distance_rms_m"]\n'
        '[[axes]]\nname = "late"\nkey = "link.latency"\nvalues = [0.0]\n',
        encoding="utf-8",
    )
    with pytest.raises(StudyError, match=r"--set link.latency: expected a key that no axis sets; late does"):
        studies.load(str(file), overrides={"link": {"latency": 1}})
    assert studies.load(str(file), overrides={"link": {"loss": 0.1}}, seeds=3).trials == 3


def test_a_studys_own_scenario_is_found_beside_it(tmp_path: Any) -> None:
    scenario = Path(studies.__file__).parents[2] / "scenarios" / "circle.toml"
    (tmp_path / "mine.toml").write_bytes(scenario.read_bytes())
    (tmp_path / "own.toml").write_text(
        'name = "own"\nscenarios = ["mine.toml"]\nmeasures = ["distance_rms_m"]\nseeds = 1\n', encoding="utf-8"
    )
    (trial,) = trials(studies.load(str(tmp_path / "own.toml")))
    assert trial.labels == {"scenario": "mine"}  # no path of this machine in the table


def test_a_study_that_does_not_exist_lists_what_there_is() -> None:
    with pytest.raises(StudyError, match=r"study: expected one of .*delay.*FILE.toml; got 'dely' \(did you mean delay"):
        studies.load("dely")


@pytest.mark.parametrize("name", studies.shipped())
def test_every_shipped_study_can_be_simulated(name: Any) -> None:
    study = studies.load(name)
    assert study.name == name
    assert study.title.endswith((".", "?"))
    assert len(trials(study)) == study.trials
    assert study.figures
    assert study.bounds or name == "burst"


def test_the_studies_of_the_issue_are_shipped() -> None:
    assert {"delay", "loss", "burst", "cut-and-heal", "stuck-robot", "team-size"} <= set(studies.shipped())


def test_the_command_lists_studies_with_their_trials(capsys: Any) -> None:
    assert command.main(["study", "--list", "--json"]) == 0
    listed = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)["studies"]}
    assert listed["delay"]["trials"] == studies.load("delay").trials
    assert set(listed) == set(studies.shipped())


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["delay", "--seeds", "0"], "--seeds: expected at least 1; got 0"),
        (["delay", "--workers", "0"], "--workers: expected at least 1; got 0"),
        (["delay", "--workers", "1", "--cluster", "tcp://x:1"], "--workers: expected no number with --cluster"),
        (["nothing"], "study: expected one of"),
        (["delay", "--set", "duration=1"], "delay: warmup: expected less than 1 s; got 20 (at triangle-circle, contr"),
    ],
)
def test_a_mistake_on_the_command_line_is_one_line(arguments: Any, line: Any, capsys: Any, tmp_path: Any) -> None:
    assert command.main(["study", *arguments, "--out", str(tmp_path)]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith(f"echelon study: {line}")
    assert len(told.err.splitlines()) == 1


def test_an_error_of_a_study_is_one_of_the_project() -> None:
    assert issubclass(StudyError, EchelonError)


@pytest.mark.parametrize("name", ["own.TOML", "own.toml"])
def test_a_study_and_its_scenarios_may_have_a_suffix_in_capitals_and_a_byte_order_mark(
    tmp_path: Any, name: Any
) -> None:
    raw = 'name = "own"\nscenarios = ["here.Toml", "circle"]\nmeasures = ["distance_rms_m"]\nseeds = 1\n'
    (tmp_path / name).write_text(raw, encoding="utf-8-sig")
    found = studies.load(str(tmp_path / name))
    assert found.scenarios == [str(tmp_path / "here.Toml"), "circle"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("name = 'x'".encode("utf-16"), "got UTF-16"),
        (b"\xff\xfa", "UTF-8"),
        (b"name = ", "expected TOML"),
        (None, "no"),
    ],
)
def test_a_study_that_cannot_be_read_is_refused_in_a_line(tmp_path: Any, content: Any, words: Any) -> None:
    file = tmp_path / "own.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(StudyError, match=words) as caught:
        studies.load(str(file))
    assert "\n" not in str(caught.value)
