"""Study files and their grids: every mistake is told, every flight is complete, and all meet the same chance."""

# mypy: disable-error-code="no-any-return"

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli import main as command
from experiments.study import study as studies
from experiments.study.flights import simulate
from experiments.study.grid import Job, code_version, jobs
from experiments.study.outcomes import MEASURES
from experiments.study.study import parse
from formation.arrays import FloatArray
from formation.errors import EchelonError, StudyError
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation
from world.trace import Trace

BASE: dict[str, Any] = {
    "name": "small",
    "scenarios": ["triangle-circle"],
    "settings": ["duration=1.5"],
    "seeds": 2,
    "measures": ["distance_rms_m"],
    "axes": [
        {"name": "controller", "key": "controller.name", "values": ["nash", "leader_follower"]},
        {"name": "latency", "key": "link.latency", "values": [0.0, 0.2, 0.5], "unit": "s"},
    ],
}
NOISE = "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}"


def test_the_grid_is_every_combination_once_with_the_seed_changing_fastest() -> None:
    study = parse(BASE)
    found = jobs(study)
    assert len(found) == study.flights == 12
    cells = [(dict(job.cell)["controller"], dict(job.cell)["latency"], job.seed) for job in found]
    assert cells == [(c, t, s) for c in ("nash", "leader_follower") for t in (0.0, 0.2, 0.5) for s in (0, 1)]
    assert [job.index for job in found] == list(range(12))
    assert len({job.key for job in found}) == 12


def test_a_job_holds_all_of_its_flight() -> None:
    for job in jobs(parse(BASE)):
        flown, cell = Scenario.model_validate_json(job.scenario), dict(job.cell)
        assert flown.duration == 1.5
        assert flown.controller.name == cell["controller"]
        assert flown.link.latency == cell["latency"]
        assert flown.seed == job.seed
        assert job.cost == 150 * 3


def test_choices_are_settings_by_name() -> None:
    axis = {"name": "how", "choices": {"aged": [], "fresh": ["controller.age_plans=false", "link.latency=0.3"]}}
    found = jobs(parse(BASE | {"axes": [axis], "seeds": 1}))
    first, second = (Scenario.model_validate_json(job.scenario) for job in found)
    assert first.controller.age_plans is None
    assert second.controller.age_plans is False
    assert second.link.latency == 0.3
    assert [dict(job.cell)["how"] for job in found] == ["aged", "fresh"]


def test_scheduled_faults_survive_the_journey() -> None:
    faults = 'faults=[{link="1->2", at=0.5, until=1, loss=0.0}]'
    (job,) = jobs(parse(BASE | {"axes": [], "seeds": 1, "settings": ["duration=2", "link.loss=0.5", faults]}))
    (entry,) = Scenario.model_validate_json(job.scenario).faults
    assert entry.changes() == {"loss": 0.0}  # set to its default, and set nevertheless


def test_the_key_of_a_flight_depends_on_what_is_flown_and_what_is_measured_only() -> None:
    def keys(**changes: Any) -> list[str]:
        return [job.key for job in jobs(parse(BASE | changes))]

    assert keys(name="other", title="?") == keys()
    assert keys(seeds=3)[:2] == keys()[:2]
    assert not set(keys(settings=["duration=1.6"])) & set(keys())
    assert not set(keys(warmup=0.5)) & set(keys())
    assert not set(keys(measures=["distance_max_m"])) & set(keys())


def flights(settings: list[str], controllers: list[str]) -> list[tuple[Scenario, Trace]]:
    axis = {"name": "who", "key": "controller.name", "values": controllers}
    found = jobs(parse(BASE | {"axes": [axis], "settings": ["duration=4", *settings]}))
    flown = [Scenario.model_validate_json(job.scenario) for job in found]
    return [(scenario, Simulation(scenario).simulate()) for scenario in flown]


def slip(scenario: Scenario, trace: Trace) -> FloatArray:
    """The draws behind the slip of v, as the true poses show them: (T, n)."""
    moved = np.diff(trace.poses, axis=0)
    chord = np.hypot(moved[..., 0], moved[..., 1])
    turn = np.arctan2(np.sin(moved[..., 2]), np.cos(moved[..., 2]))
    v = np.clip(trace.inputs[..., 0], -scenario.robots.limits.v, scenario.robots.limits.v)
    return chord / np.sinc(turn / 2.0 / np.pi) / (scenario.control_interval * np.abs(v))


def test_every_controller_meets_the_same_noise() -> None:
    (a, one), (b, again), (c, other), (_, fourth) = flights([NOISE], ["nash", "leader_follower"])
    assert [s.seed for s in (a, b, c)] == [0, 1, 0]
    # Where a robot hardly moves, or turns hard, the factor cannot be told from the poses.
    told = (np.abs(one.inputs[..., 0]) > 0.02) & (np.abs(other.inputs[..., 0]) > 0.02)
    assert told.mean() > 0.3
    np.testing.assert_allclose(slip(a, one)[told], slip(c, other)[told], rtol=1e-3)
    assert np.abs(one.poses - other.poses).max() > 0.01  # two different flights
    assert np.abs(slip(a, one)[told] - slip(b, again)[told]).mean() > 0.05  # another seed, another chance
    assert fourth.poses.shape == one.poses.shape


def test_every_controller_meets_the_same_faults() -> None:
    faults = ["link.loss=0.5", "link.burst=5", "link.jitter=0.05", "link.latency=0.1"]
    traces = [trace for _, trace in flights(faults, ["nash", "leader_follower", "paper"])]
    for seed in (0, 1):
        ages = [trace.ages for trace in traces[seed::2]]
        assert len(ages) == 3
        for other in ages[1:]:
            np.testing.assert_array_equal(ages[0], other)
    assert np.nanmax(np.abs(traces[0].ages - traces[1].ages)) > 0.05


def test_a_flight_flown_twice_gives_the_same_row() -> None:
    job = jobs(parse(BASE | {"settings": ["duration=1.5", NOISE], "measures": ["distance_rms_m", "lost_share"]}))[0]
    assert simulate(job) == simulate(job)


def test_a_worker_with_other_code_refuses() -> None:
    job = jobs(parse(BASE))[0]
    other = Job(job.index, job.cell, job.seed, job.scenario, job.measuring, "another", job.cost)
    with pytest.raises(StudyError, match=f"another version of echelon: expected code another; got {code_version()}"):
        simulate(other)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"measures": ["rms"]}, "measures[0]: expected one of distance_rms_m"),
        ({"measures": ["recovery_s"]}, "measures[0]: expected an [event] for recovery_s; got none"),
        ({"seeds": 0}, "seeds: expected at least 1; got 0"),
        ({"speed": 1}, "speed: unknown key: expected one of name, title"),
        ({"scenarios": []}, "scenarios: expected"),
        ({"settings": ["duration"]}, "settings[0]: expected"),
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


def test_what_cannot_be_flown_is_told_before_anything_is_flown() -> None:
    axis = {"name": "robots", "key": "formation.robots", "values": [3, 4, 5]}
    with pytest.raises(StudyError) as caught:
        jobs(parse(BASE | {"axes": [axis], "settings": ["duration=1", "link.loss=2"]}))
    lines = str(caught.value).splitlines()
    assert any("link.loss" in line for line in lines)
    assert any("robots = 4" in line or "got 4" in line for line in lines)
    assert all(line.startswith("small: triangle-circle: ") for line in lines)


def test_a_setting_may_not_overrule_an_axis(tmp_path: Any) -> None:
    file = tmp_path / "own.toml"
    file.write_text(
        'name = "own"\nscenarios = ["circle"]\nmeasures = ["distance_rms_m"]\n'
        '[[axes]]\nname = "late"\nkey = "link.latency"\nvalues = [0.0]\n',
        encoding="utf-8",
    )
    with pytest.raises(StudyError, match=r"--set link.latency: expected a key that no axis sets; late does"):
        studies.load(str(file), settings=["link.latency=1"])
    assert studies.load(str(file), settings=["link.loss=0.1"], seeds=3).flights == 3


def test_a_studys_own_scenario_is_found_beside_it(tmp_path: Any) -> None:
    scenario = Path(studies.__file__).parents[2] / "scenarios" / "circle.toml"
    (tmp_path / "mine.toml").write_bytes(scenario.read_bytes())
    (tmp_path / "own.toml").write_text(
        'name = "own"\nscenarios = ["mine.toml"]\nmeasures = ["distance_rms_m"]\nseeds = 1\n', encoding="utf-8"
    )
    (job,) = jobs(studies.load(str(tmp_path / "own.toml")))
    assert dict(job.cell) == {"scenario": "mine"}  # no path of this machine in the table


def test_a_study_that_does_not_exist_lists_what_there_is() -> None:
    with pytest.raises(StudyError, match=r"study: expected one of .*delay.*FILE.toml; got 'dely' \(did you mean delay"):
        studies.load("dely")


@pytest.mark.parametrize("name", studies.shipped())
def test_every_shipped_study_can_be_flown(name: Any) -> None:
    study = studies.load(name)
    assert study.name == name
    assert study.title.endswith((".", "?"))
    assert len(jobs(study)) == study.flights
    assert study.figures
    assert study.bounds or name == "burst"


def test_the_studies_of_the_issue_are_shipped() -> None:
    assert {"delay", "loss", "burst", "cut-and-heal", "stuck-robot", "team-size"} <= set(studies.shipped())


def test_every_measure_has_its_unit_at_the_end_of_its_name() -> None:
    for name, measure in MEASURES.items():
        assert name.endswith({"1": "_share"}.get(measure.unit, f"_{measure.unit}"))


def test_the_command_lists_studies_with_their_flights(capsys: Any) -> None:
    assert command.main(["study", "--list", "--json"]) == 0
    listed = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)["studies"]}
    assert listed["delay"]["flights"] == studies.load("delay").flights
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
