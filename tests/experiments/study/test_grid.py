"""The grid of a study: every trial is complete, and all meet the same noise and the same faults."""

# mypy: disable-error-code="no-any-return"

from typing import Any

import numpy as np
import pytest

from experiments.study.grid import trials
from experiments.study.study import parse
from formation.arrays import FloatArray
from formation.errors import StudyError
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation
from world.measures.trace import Trace

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
NOISE = {"noise": {"slip": 0.2, "gyro": 0.2, "position": 0.001, "heading": 0.01}}


def test_the_grid_is_every_combination_once_with_the_seed_changing_fastest() -> None:
    study = parse(BASE)
    found = trials(study)
    assert len(found) == study.trials == 12
    cells = [(trial.labels["controller"], trial.labels["latency"], trial.seed) for trial in found]
    assert cells == [(c, t, s) for c in ("nash", "leader_follower") for t in (0.0, 0.2, 0.5) for s in (0, 1)]
    assert len({trial.key for trial in found}) == 12


def test_a_trial_holds_all_of_its_simulation() -> None:
    for trial in trials(parse(BASE)):
        scenario, cell = trial.load(), trial.labels
        assert scenario.duration == 1.5
        assert scenario.controller.name == cell["controller"]
        assert scenario.link.latency == cell["latency"]
        assert scenario.seed == trial.seed
        assert trial.cost == 150 * 3


def test_choices_are_overrides_by_name() -> None:
    axis = {
        "name": "how",
        "choices": {"aged": {}, "fresh": {"controller": {"age_plans": False}, "link": {"latency": 0.3}}},
    }
    found = trials(parse(BASE | {"axes": [axis], "seeds": 1}))
    first, second = (trial.load() for trial in found)
    assert first.controller.age_plans is None
    assert second.controller.age_plans is False
    assert second.link.latency == 0.3
    assert [trial.labels["how"] for trial in found] == ["aged", "fresh"]


def test_scheduled_faults_survive_the_journey() -> None:
    faults = [{"link": "1->2", "at": 0.5, "until": 1, "loss": 0.0}]
    (trial,) = trials(
        parse(BASE | {"axes": [], "seeds": 1, "overrides": {"duration": 2, "link": {"loss": 0.5}, "faults": faults}})
    )
    (entry,) = trial.load().faults
    assert entry.changes() == {"loss": 0.0}  # set to its default, and set nevertheless


def test_the_key_of_a_trial_depends_on_what_is_simulated_and_what_is_measured_only() -> None:
    def keys(**changes: Any) -> list[str]:
        return [trial.key for trial in trials(parse(BASE | changes))]

    assert keys(name="other", title="?") == keys()
    assert keys(seeds=3)[:2] == keys()[:2]
    assert not set(keys(overrides={"duration": 1.6})) & set(keys())
    assert not set(keys(warmup=0.5)) & set(keys())
    assert not set(keys(measures=["distance_max_m"])) & set(keys())


def traces_of(overrides: dict[str, Any], controllers: list[str]) -> list[tuple[Scenario, Trace]]:
    axis = {"name": "who", "key": "controller.name", "values": controllers}
    found = trials(parse(BASE | {"axes": [axis], "overrides": {"duration": 4, **overrides}}))
    scenarios = [trial.load() for trial in found]
    return [(scenario, Simulation(scenario).simulate()) for scenario in scenarios]


def slip(scenario: Scenario, trace: Trace) -> FloatArray:
    """The draws behind the slip of v, as the true poses show them: (T, n)."""
    moved = np.diff(trace.poses, axis=0)
    chord = np.hypot(moved[..., 0], moved[..., 1])
    turn = np.arctan2(np.sin(moved[..., 2]), np.cos(moved[..., 2]))
    v = np.clip(trace.inputs[..., 0], -scenario.robots.limits.v, scenario.robots.limits.v)
    return chord / np.sinc(turn / 2.0 / np.pi) / (scenario.control_interval * np.abs(v))


def test_every_controller_meets_the_same_noise() -> None:
    (a, one), (b, again), (c, other), (_, fourth) = traces_of(NOISE, ["nash", "leader_follower"])
    assert [s.seed for s in (a, b, c)] == [0, 1, 0]
    # Where a robot hardly moves, or turns hard, the factor cannot be told from the poses.
    told = (np.abs(one.inputs[..., 0]) > 0.02) & (np.abs(other.inputs[..., 0]) > 0.02)
    assert told.mean() > 0.3
    np.testing.assert_allclose(slip(a, one)[told], slip(c, other)[told], rtol=1e-3)
    assert np.abs(one.poses - other.poses).max() > 0.01  # two different trajectories
    assert np.abs(slip(a, one)[told] - slip(b, again)[told]).mean() > 0.05  # another seed, another chance
    assert fourth.poses.shape == one.poses.shape


def test_every_controller_meets_the_same_faults() -> None:
    faults = {"link": {"loss": 0.5, "burst": 5, "jitter": 0.05, "latency": 0.1}}
    traces = [trace for _, trace in traces_of(faults, ["nash", "leader_follower", "paper"])]
    for seed in (0, 1):
        ages = [trace.ages for trace in traces[seed::2]]
        assert len(ages) == 3
        for other in ages[1:]:
            np.testing.assert_array_equal(ages[0], other)
    assert np.nanmax(np.abs(traces[0].ages - traces[1].ages)) > 0.05


def test_what_cannot_be_simulated_is_refused_before_anything_is() -> None:
    axis = {"name": "robots", "key": "formation.robots", "values": [3, 4, 5]}
    with pytest.raises(StudyError) as caught:
        trials(parse(BASE | {"axes": [axis], "overrides": {"duration": 1, "link": {"loss": 2}}}))
    lines = str(caught.value).splitlines()
    assert any("link.loss" in line for line in lines)
    assert any("robots = 4" in line or "got 4" in line for line in lines)
    assert all(line.startswith("small: triangle-circle: ") for line in lines)
