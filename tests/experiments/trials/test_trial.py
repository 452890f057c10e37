"""Laws of a trial: complete, named by its key, the same result wherever it runs and whatever it is written to."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from experiments.trials.code_version import code_version
from experiments.trials.result import Signals, result_of
from experiments.trials.simulate import simulate
from experiments.trials.trial import GAP_EVERY, Measurement, Trial, trial
from formation.errors import EchelonError, ScenarioError
from network.values import Excursion
from runtime.inprocess import Simulation

KEPT = Measurement(("distance_rms_m", "lost_share"), warmup=0.5, series=True, signals=True, gap=True)


@pytest.fixture(scope="module")
def one() -> Trial:
    overrides = {"duration": 1.5, "noise": {"slip": 0.2}, "link": {"loss": 0.3}}
    return trial("one", "triangle-circle", overrides, 3, KEPT)


def test_a_trial_has_its_seed_and_its_overrides(one: Any) -> None:
    scenario = one.load()
    assert (scenario.seed, scenario.duration, scenario.link.loss) == (3, 1.5, 0.3)
    assert one.cost == scenario.ticks * scenario.size


def test_a_longer_scenario_is_cut_and_a_shorter_one_is_not() -> None:
    for limit, duration in ((1.0, 1.0), (9.0, 1.5)):
        cut = trial("cut", "triangle-circle", {"duration": 1.5}, 0, KEPT, limit=limit)
        assert cut.load().duration == duration


def test_a_wrong_override_is_refused_when_the_trial_is_made() -> None:
    with pytest.raises(ScenarioError, match=r"triangle-circle: link.loss: expected"):
        trial("wrong", "triangle-circle", {"link": {"loss": 2}}, 0, KEPT)


def test_names_and_labels_are_not_part_of_the_key_and_everything_else_is(one: Any) -> None:
    assert replace(one, name="other", labels={"a": 1}).key == one.key
    others = [
        replace(one, seed=4),
        replace(one, code="other"),
        replace(one, scenario=one.scenario | {"duration": 1.4}),
        replace(one, measurement=replace(KEPT, warmup=0.6)),
        replace(one, measurement=replace(KEPT, gap=False)),
    ]
    assert len({one.key, *(other.key for other in others)}) == 1 + len(others)


def test_a_value_keeps_its_quotes_and_its_line_breaks() -> None:
    text = "\"quoted\", 'twice'\nand = more"
    assert trial("quoted", "circle", {"source": text}, 0, KEPT).load().source == text


def test_a_result_survives_json_to_the_last_bit(one: Any) -> None:
    result, plain = simulate(one), json.loads(json.dumps(one.run()))
    again = result_of(one, plain)
    assert (again.values, again.trajectory_sha256) == (result.values, result.trajectory_sha256)
    np.testing.assert_array_equal(again.series, result.series)
    assert again.signals is not None
    assert result.signals is not None
    for name in Signals.__slots__:
        np.testing.assert_array_equal(getattr(again.signals, name), getattr(result.signals, name))


def test_the_ledger_survives_json(one: Any) -> None:
    result, seen = simulate(one), Excursion(1, 2, 20.5, 0.02, 24.0, until=25.0, recovery=1.0, cause="x", cause_at=20.0)
    assert result.signals is not None
    ledger = (seen, Excursion(2, 3, 40.0, 0.01, 41.0))
    told = replace(result, signals=replace(result.signals, excursions=ledger))
    again = result_of(one, json.loads(json.dumps(told.plain()))).signals
    assert again is not None
    assert again.excursions == ledger


def test_signals_are_those_of_the_simulation(one: Any) -> None:
    trace, signals = Simulation(one.load()).simulate(), simulate(one).signals
    assert signals is not None
    np.testing.assert_array_equal(signals.poses, trace.poses)
    for found, wanted in zip((signals.distance, signals.angle, signals.tracking), trace.errors(), strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert signals.gaps.shape == (150 // GAP_EVERY, 3)


def test_what_was_not_asked_for_is_not_kept(one: Any) -> None:
    plain = simulate(replace(one, measurement=Measurement(("clearance_m",)))).plain()
    assert set(plain["values"]) == {"clearance_m"}
    assert plain["series"] == []
    assert plain["signals"] is None


def test_rows_after_a_time_include_it_and_a_trial_cut_before_has_its_last(one: Any) -> None:
    signals = simulate(one).signals
    assert signals is not None
    assert signals.times[signals.after(0.5)][0] == pytest.approx(0.5)
    assert signals.times[signals.after(0.5, 1.0)][-1] == pytest.approx(1.0)
    assert signals.times[signals.after(99.0)].tolist() == [signals.times[-1]]


def test_a_worker_with_other_code_refuses(one: Any) -> None:
    with pytest.raises(EchelonError, match=f"another version of echelon: expected code other; got {code_version()}"):
        replace(one, code="other").run()


def test_a_trial_of_a_file_needs_no_file_any_more(tmp_path: Any) -> None:
    (tmp_path / "way.csv").write_text("x,y\n0,0\n1,0\n1,1\n0,1\n", encoding="utf-8")
    (tmp_path / "own.toml").write_text(
        'name = "own"\n[path]\nkind = "waypoints"\nfile = "way.csv"\nspeed = 0.1\n[formation]\nshape = "triangle"\n',
        encoding="utf-8",
    )
    own = trial("own", str(tmp_path / "own.toml"), {"duration": 1.0}, 0, KEPT)
    before = own.load()
    for file in tmp_path.iterdir():
        file.unlink()
    assert own.load() == before
