"""Laws of shapes and curves."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from dashboard.scene import geometry
from formation import unicycle


@given(
    st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-2.0, 2.0)), min_size=1, max_size=20),
    st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-3.0, 3.0)),
)
def test_a_plan_is_drawn_where_the_body_would_drive(
    inputs: list[tuple[float, float]], start: tuple[float, float, float]
) -> None:
    drawn = geometry.roll_out(np.array([start]), np.array([inputs]), 0.1)[0]
    pose = start
    for step, (v, omega) in enumerate(inputs, start=1):
        pose = unicycle.step(*pose, v, omega, 0.1)
        np.testing.assert_allclose(drawn[step], pose[:2], atol=1e-12)
