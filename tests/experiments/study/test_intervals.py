"""Statistics over seeds: intervals, paired ratios, bounds."""

# mypy: disable-error-code="no-any-return"

import math
from typing import Any

import numpy as np
import pytest

from experiments.study.intervals import check_bounds, groups, interval, student, summary
from experiments.study.study import parse
from experiments.study.table import Row


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


def test_ratios_pair_trials_of_the_same_seed() -> None:
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
    assert (last["trials"], last["missing"], last["mean"], last["max"]) == (3, 1, 3.0, 4.0)
    assert rows[0]["mean"] == pytest.approx(7.0 / 3.0)


def test_a_bound_is_checked_where_it_is_worst_and_what_never_came_breaks_it() -> None:
    ratio, largest, recovered = check_bounds(STUDY, groups(STUDY, table()))
    assert ratio.found == pytest.approx(1.5)
    assert ratio.holds
    assert (largest.found, largest.cell["late"], largest.holds) == (6.0, 1.0, False)
    assert (recovered.found, recovered.holds) == (math.inf, False)
