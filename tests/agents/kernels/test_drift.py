"""Laws of what is believed of an estimated lateral drift (docs/theory.md, section 13)."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.kernels.drifting import believed

DRIFTS = st.floats(-0.2, 0.2)
NOISES = st.floats(0.0, 0.02)


@given(noise=NOISES)
def test_nothing_is_believed_where_nothing_is_estimated(noise: float) -> None:
    assert believed(0.0, noise) == 0.0


@given(drift=DRIFTS.filter(lambda drift: drift == 0.0 or abs(drift) > 1e-100))
def test_all_is_believed_where_there_is_no_noise(drift: float) -> None:
    assert believed(drift, 0.0) == drift


@given(drift=DRIFTS, noise=NOISES)
def test_never_is_more_believed_than_is_estimated_nor_the_contrary(drift: float, noise: float) -> None:
    found = believed(drift, noise)
    assert abs(found) <= abs(drift)
    assert found * drift >= 0.0


@given(noise=st.floats(1e-5, 0.02), times=st.floats(0.01, 100.0), sign=st.sampled_from([-1.0, 1.0]))
def test_a_drift_far_above_the_noise_is_kept_and_one_far_below_is_not(noise: float, times: float, sign: float) -> None:
    share = believed(sign * times * noise, noise) / (sign * times * noise)
    np.testing.assert_allclose(share, times**2 / (1.0 + times**2), rtol=1e-9)
    assert believed(sign * 10.0 * noise, noise) / (sign * 10.0 * noise) > 0.99
    assert believed(sign * 0.1 * noise, noise) / (sign * 0.1 * noise) < 0.01
