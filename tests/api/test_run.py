"""A live run from Python refuses what makes no sense before it starts a process, and says when it is over."""

from typing import Any

import pytest

import echelon


@pytest.mark.parametrize("speed", [-1, 1001.0, float("nan"), float("inf"), "fast"])
def test_a_speed_is_checked_before_anything_starts(speed: Any) -> None:
    with pytest.raises(echelon.EchelonError, match=r"^speed: expected 0 \(as fast as possible\) to 1000; got "):
        echelon.launch("circle", page=False, speed=speed)
