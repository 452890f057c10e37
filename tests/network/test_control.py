"""Laws of what users may ask of a run, before it is asked."""

from typing import Any

import numpy as np
import pytest

from formation.errors import EchelonError
from network.control import checked_speed


@pytest.mark.parametrize("speed", [0, 0.5, 1000, np.float64(2.0), np.int64(3)])
def test_a_speed_is_a_number_from_0_to_1000(speed: Any) -> None:
    assert checked_speed(speed) == float(speed)


@pytest.mark.parametrize(
    ("speed", "got"),
    [(-1, "-1"), (-0.5, "-0.5"), (1000.5, "1000.5"), (float("nan"), "nan"), (float("inf"), "inf"), ("x", "'x'")],
)
def test_any_other_speed_is_refused(speed: Any, got: str) -> None:
    with pytest.raises(EchelonError) as caught:
        checked_speed(speed, "--speed")
    assert str(caught.value) == f"--speed: expected 0 (as fast as possible) to 1000; got {got}"
