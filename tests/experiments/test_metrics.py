"""Laws of the metrics that reports and studies share."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.metrics import recovery, spread, trailing_rms
from formation.metrics import rms

numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-12)


@given(st.lists(numbers, min_size=1, max_size=50))
def test_a_spread_is_in_order_and_within_its_range(values: Any) -> None:
    found = spread(np.array(values))
    assert found.minimum <= found.lower <= found.median <= found.upper <= found.maximum
    assert (found.minimum, found.maximum) == (min(values), max(values))
    assert found.rms == pytest.approx(math.sqrt(sum(v * v for v in values) / len(values)), abs=1e-9)
    assert found.width >= 0.0


def test_the_rms_of_a_sine_is_its_size_over_root_two() -> None:
    assert rms(np.sin(np.linspace(0.0, 2.0 * np.pi, 10001)[:-1])) == pytest.approx(math.sqrt(0.5))


def test_trailing_rms_is_that_of_the_last_samples() -> None:
    values = np.random.default_rng(1).normal(size=(50, 3))
    found = trailing_rms(values, 7)
    for k in (0, 3, 6, 7, 49):
        np.testing.assert_allclose(found[k], np.sqrt(np.mean(values[max(0, k - 6) : k + 1] ** 2, axis=0)), rtol=1e-9)
    np.testing.assert_array_equal(trailing_rms(values, 1), np.abs(values))


def test_what_has_recovered_stays_below() -> None:
    times = np.arange(6.0)
    assert recovery(times, np.array([5.0, 5.0, 1.0, 5.0, 1.0, 1.0]), below=2.0, since=0.0) == 4.0
    assert recovery(times, np.ones(6), below=2.0, since=0.0) == 0.0
    assert recovery(times, np.array([1.0, 1.0, 1.0, 1.0, 1.0, 5.0]), below=2.0, since=0.0) is None


def test_what_ends_before_recovery_can_begin_has_not_recovered() -> None:
    assert recovery(np.arange(6.0), np.zeros(6), below=2.0, since=9.0) is None
