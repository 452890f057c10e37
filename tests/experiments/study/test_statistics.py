"""What is measured of a flight, and what is said of many: recovery, clearance, intervals, paired ratios, bounds."""

# mypy: disable-error-code="no-any-return"

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.study.intervals import groups, interval, student, summary, verdicts
from experiments.study.outcomes import MEASURES, Event, Record, trailing_rms
from experiments.study.study import parse
from experiments.study.table import Row
from formation.arrays import FloatArray

DT = 0.1


def measured(level: FloatArray, event: Event | None = None, poses: FloatArray | None = None) -> Record:
    times: FloatArray = DT * np.arange(len(level), dtype=np.float64)
    where = np.zeros((len(level), 2, 3)) if poses is None else poses
    signed = np.stack([level, -level / 2.0], axis=1)
    return Record(times, where, signed, signed, level, signed[1:], {}, level, event)


def recovery(level: Any, **event: Any) -> float:
    return MEASURES["recovery_s"].of(measured(np.array(level, float), Event.model_validate(event)))


def test_recovery_is_counted_from_the_events_end_to_the_last_time_above_the_threshold() -> None:
    level = [0, 0, 9, 9, 9, 9, 0, 9, 0, 0, 0]  # one sample each 0.1 s
    assert recovery(level, at=0.2, until=0.4, below=1.0) == pytest.approx(0.4)
    assert recovery(level, at=0.2, until=0.4, below=10.0) == 0.0


def test_recovery_with_a_hold_forgives_what_comes_after_it() -> None:
    level = [0, 0, 9, 9, 9, 0, 0, 9, 0, 0, 0, 0, 9, 9]
    assert recovery(level, at=0.2, until=0.4, below=1.0, hold=0.4) == pytest.approx(0.4)
    assert recovery(level, at=0.2, until=0.4, below=1.0, hold=0.2) == pytest.approx(0.1)
    assert math.isnan(recovery(level, at=0.2, until=0.4, below=1.0))
    assert math.isnan(recovery(level, at=0.2, until=0.4, below=1.0, hold=0.5))


def test_recovery_may_be_relative_to_the_level_before() -> None:
    level = [2, 3, 9, 9, 9, 5, 4, 1, 1, 1]
    assert recovery(level, at=0.2, until=0.4, factor=1.0) == pytest.approx(0.3)
    assert recovery(level, at=0.2, until=0.4, factor=1.5) == pytest.approx(0.2)


@given(st.lists(st.floats(0, 10), min_size=6, max_size=40), st.floats(0.1, 9.9))
def test_after_its_recovery_a_flight_stays_below(level: Any, below: Any) -> None:
    found = recovery(level, at=0.1, until=0.2, below=below)
    times = DT * np.arange(len(level))
    after = np.array(level)[times >= 0.2 - 1e-9]
    if math.isnan(found):
        assert after[-1] >= below
    else:
        k = round(found / DT)
        assert (after[k:] < below).all()
        assert k == 0 or after[k - 1] >= below


def test_the_event_counts_from_its_beginning() -> None:
    level = np.array([7.0, 1.0, 2.0, 5.0, 3.0])
    event = Event(at=0.1, until=0.3, below=1.0)
    assert MEASURES["event_max_m"].of(measured(level, event)) == 5.0
    assert MEASURES["distance_max_m"].of(measured(level, event)) == 7.0
    assert MEASURES["distance_final_m"].of(measured(level, event)) == 3.0


def test_trailing_rms_is_that_of_the_last_samples() -> None:
    values = np.random.default_rng(1).normal(size=(50, 3))
    found = trailing_rms(values, 7)
    for k in (0, 3, 6, 7, 49):
        np.testing.assert_allclose(found[k], np.sqrt(np.mean(values[max(0, k - 6) : k + 1] ** 2, axis=0)), rtol=1e-9)
    np.testing.assert_array_equal(trailing_rms(values, 1), np.abs(values))


def test_clearance_is_the_least_distance_of_any_two_robots_at_any_time(monkeypatch: Any) -> None:
    poses = np.random.default_rng(2).normal(size=(40, 5, 3))
    all_gaps = [
        np.hypot(*(poses[k, i, :2] - poses[k, j, :2])) for k in range(40) for i in range(5) for j in range(5) if i != j
    ]
    record = measured(np.zeros(40), poses=poses)
    assert MEASURES["clearance_m"].of(record) == pytest.approx(min(all_gaps))
    monkeypatch.setattr("formation.metrics.PAIRS_AT_ONCE", 30)  # the same in slices
    assert MEASURES["clearance_m"].of(record) == pytest.approx(min(all_gaps))


@pytest.mark.parametrize(
    ("freedom", "quantile"), [(1, 12.7062), (2, 4.30265), (4, 2.776445), (9, 2.262157), (29, 2.04523), (99, 1.984217)]
)
def test_students_quantile_is_that_of_the_tables(freedom: Any, quantile: Any) -> None:
    assert student(freedom) == pytest.approx(quantile, rel=2e-5)


def test_an_interval_holds_the_true_mean_nineteen_times_in_twenty() -> None:
    draws = np.random.default_rng(3).normal(5.0, 2.0, size=(4000, 6))
    found = [interval(row) for row in draws]
    hits = [over.low <= 5.0 <= over.high for over in found if over is not None]
    assert len(hits) == 4000
    assert 0.94 < np.mean(hits) < 0.96


def test_an_interval_of_one_has_no_width_and_of_none_is_none() -> None:
    only = interval(np.array([3.0]))
    assert only is not None
    assert (only.mean, only.low, only.high) == (3.0, 3.0, 3.0)
    assert interval(np.array([])) is None


STUDY = parse(
    {
        "name": "made-up",
        "scenarios": ["circle"],
        "seeds": 3,
        "measures": ["distance_rms_m", "recovery_s"],
        "event": {"at": 20, "until": 24, "below": 0.002},
        "axes": [{"name": "late", "key": "link.latency", "values": [0.0, 1.0]}],
        "baseline": {"late": 0.0},
        "bounds": [
            {"where": {"late": 1.0}, "measure": "distance_rms_m", "statistic": "ratio", "at_most": 2.0},
            {"measure": "distance_rms_m", "statistic": "max", "at_most": 5.0},
            {"measure": "recovery_s", "statistic": "max", "at_most": 100.0},
        ],
    }
)


def table() -> list[Row]:
    measures = {0.0: ((1.0, 1.0), (2.0, 1.0), (4.0, 1.0)), 1.0: ((2.0, 2.0), (2.0, None), (6.0, 4.0))}
    return [
        {"scenario": "circle", "late": late, "seed": seed, "distance_rms_m": rms, "recovery_s": after}
        for late, values in measures.items()
        for seed, (rms, after) in enumerate(values)
    ]


def test_ratios_pair_flights_of_the_same_seed() -> None:
    found = {(g.cell["late"], g.measure): g for g in groups(STUDY, table())}
    np.testing.assert_array_equal(found[1.0, "distance_rms_m"].ratios, [2.0, 1.0, 1.5])
    np.testing.assert_array_equal(found[0.0, "distance_rms_m"].ratios, [1.0, 1.0, 1.0])
    assert found[1.0, "recovery_s"].missing == 1
    np.testing.assert_array_equal(found[1.0, "recovery_s"].ratios, [2.0, 4.0])


def test_the_summary_tells_how_many_never_recovered() -> None:
    rows, columns = summary(STUDY, groups(STUDY, table()))
    assert [(row["late"], row["measure"]) for row in rows] == [
        (late, measure) for late in (0.0, 1.0) for measure in STUDY.measures
    ]
    assert set(columns) == set(rows[0])
    last = rows[-1]
    assert (last["flights"], last["missing"], last["mean"], last["max"]) == (3, 1, 3.0, 4.0)
    assert rows[0]["mean"] == pytest.approx(7.0 / 3.0)


def test_a_bound_is_judged_where_it_is_worst_and_what_never_came_breaks_it() -> None:
    ratio, largest, recovered = verdicts(STUDY, groups(STUDY, table()))
    assert ratio.found == pytest.approx(1.5)
    assert ratio.holds
    assert (largest.found, largest.cell["late"], largest.holds) == (6.0, 1.0, False)
    assert (recovered.found, recovered.holds) == (math.inf, False)
