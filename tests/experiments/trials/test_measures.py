"""What is measured of a trial: recovery from an event, clearance, errors of the worst robot."""

# mypy: disable-error-code="no-any-return"

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.trials.measures import MEASURES, Event, Record, measured
from formation.arrays import FloatArray
from network.values import Excursion, LinkCounts

DT = 0.1


def made_up(level: FloatArray, event: Event | None = None, poses: FloatArray | None = None) -> Record:
    times: FloatArray = DT * np.arange(len(level), dtype=np.float64)
    where = np.zeros((len(level), 2, 3)) if poses is None else poses
    signed = np.stack([level, -level / 2.0], axis=1)
    return Record(times, where, signed, signed, level, signed[1:], (), level, event)


def recovery(level: Any, **event: Any) -> float | None:
    return MEASURES["recovery_s"].of(made_up(np.array(level, float), Event.model_validate(event)))


def test_recovery_is_counted_from_the_events_end_to_the_last_time_above_the_threshold() -> None:
    level = [0, 0, 9, 9, 9, 9, 0, 9, 0, 0, 0]  # one sample each 0.1 s
    assert recovery(level, at=0.2, until=0.4, below=1.0) == pytest.approx(0.4)
    assert recovery(level, at=0.2, until=0.4, below=10.0) == 0.0


def test_recovery_with_a_hold_forgives_what_comes_after_it() -> None:
    level = [0, 0, 9, 9, 9, 0, 0, 9, 0, 0, 0, 0, 9, 9]
    assert recovery(level, at=0.2, until=0.4, below=1.0, hold=0.4) == pytest.approx(0.4)
    assert recovery(level, at=0.2, until=0.4, below=1.0, hold=0.2) == pytest.approx(0.1)
    assert recovery(level, at=0.2, until=0.4, below=1.0) is None
    assert recovery(level, at=0.2, until=0.4, below=1.0, hold=0.5) is None


def test_recovery_may_be_relative_to_the_level_before() -> None:
    level = [2, 3, 9, 9, 9, 5, 4, 1, 1, 1]
    assert recovery(level, at=0.2, until=0.4, factor=1.0) == pytest.approx(0.3)
    assert recovery(level, at=0.2, until=0.4, factor=1.5) == pytest.approx(0.2)


@given(st.lists(st.floats(0, 10), min_size=6, max_size=40), st.floats(0.1, 9.9))
def test_after_its_recovery_a_trial_stays_below(level: Any, below: Any) -> None:
    found = recovery(level, at=0.1, until=0.2, below=below)
    times = DT * np.arange(len(level))
    after = np.array(level)[times >= 0.2 - 1e-9]
    if found is None:
        assert after[-1] >= below
    else:
        k = round(found / DT)
        assert (after[k:] < below).all()
        assert k == 0 or after[k - 1] >= below


def test_the_event_counts_from_its_beginning() -> None:
    level = np.array([7.0, 1.0, 2.0, 5.0, 3.0])
    event = Event(at=0.1, until=0.3, below=1.0)
    assert MEASURES["event_max_m"].of(made_up(level, event)) == 5.0
    assert MEASURES["distance_max_m"].of(made_up(level, event)) == 7.0
    assert MEASURES["distance_final_m"].of(made_up(level, event)) == 3.0


def test_clearance_is_the_least_distance_of_any_two_robots_at_any_time(monkeypatch: Any) -> None:
    poses = np.random.default_rng(2).normal(size=(40, 5, 3))
    all_gaps = [
        np.hypot(*(poses[k, i, :2] - poses[k, j, :2])) for k in range(40) for i in range(5) for j in range(5) if i != j
    ]
    record = made_up(np.zeros(40), poses=poses)
    assert MEASURES["clearance_m"].of(record) == pytest.approx(min(all_gaps))
    monkeypatch.setattr("formation.metrics.PAIRS_AT_ONCE", 30)  # the same in slices
    assert MEASURES["clearance_m"].of(record) == pytest.approx(min(all_gaps))


def test_a_measure_without_a_finite_value_is_none() -> None:
    silent = made_up(np.ones(5))
    assert measured(("lost_share",), silent) == {"lost_share": None}
    ageless = Record(**{name: getattr(silent, name) for name in Record.__slots__} | {"ages": np.full((4, 2), np.nan)})
    assert measured(("age_median_s", "age_max_s"), ageless) == {"age_median_s": None, "age_max_s": None}


def test_the_share_of_lost_plans_is_over_all_links() -> None:
    silent = made_up(np.ones(5))
    counts = (LinkCounts(sent=6, lost=3), LinkCounts(sent=4, lost=1))
    lossy = Record(**{name: getattr(silent, name) for name in Record.__slots__} | {"counts": counts})
    assert measured(("lost_share",), lossy) == {"lost_share": 0.4}


ENDINGS = {
    "1": "_share",
    "pairs": "contacts",
    "times": "excursions",
    "m/s": "_mps",
    "1/s": "_per_s",
    "B/s": "bytes_per_s",
}
"""Of a measure's name, by unit; other units stand there as they are."""


def test_every_measure_has_its_unit_at_the_end_of_its_name() -> None:
    for name, measure in MEASURES.items():
        assert name.endswith(ENDINGS.get(measure.unit, f"_{measure.unit}"))


def test_excursions_are_counted_and_one_that_goes_on_has_not_recovered() -> None:
    over = Excursion(1, 2, at=1.0, peak=0.03, peak_at=1.2, until=2.0, recovery=0.8)
    names = ("excursions", "excursion_peak_m", "excursion_recovery_s")
    for rows, values in (
        ((), (0.0, 0.0, 0.0)),
        ((over, dataclasses.replace(over, number=2, peak=0.05, recovery=0.1)), (2.0, 0.05, 0.8)),
        ((over, dataclasses.replace(over, number=2, until=None, recovery=None)), (2.0, 0.03, None)),
    ):
        trial = dataclasses.replace(made_up(np.zeros(5)), excursions=rows)
        assert tuple(measured(names, trial).values()) == values
