"""Laws of the comparison of the run with the ghost."""

from dataclasses import replace
from html import escape
from typing import Any

import numpy as np
import pytest

from dashboard.panels.comparison import comparison
from dashboard.telemetry.ghost_track import Comparison, comparisons
from dashboard.telemetry.history import History
from tests.builders import state
from tests.dashboard.fakes import beside, compared, ghost


@pytest.mark.parametrize(
    ("live", "other", "factor"),
    [
        (0.001, 0.012, "12 x better"),
        (0.012, 0.001, "12 x worse"),
        (0.001, 0.00104, "the same"),
        (0.001, 0.0025, "2.5 x better"),
        (1e-9, 1e-8, "the same"),
        (1e-9, 0.0472, "> 1000 x better"),
    ],
)
def test_the_ratio_of_the_errors_is_shown_in_words(live: float, other: float, factor: str) -> None:
    history = compared(live, other)
    found = comparisons(history.series())
    assert [row.factor for row in found] == [factor, factor]
    html = comparison(beside(30.0), history, history.series(), 20.0)
    assert html.count(escape(factor)) == 2
    assert "nash" in html
    assert "paper" in html


def test_only_the_time_that_both_have_is_compared() -> None:
    history = compared(0.001, 0.01, seconds=5.0)
    for i in range(100, 200):  # the ghost is silent, and the run has large errors
        history.add(beside(0.05 * i, distance_errors=np.full(3, 9.0)), [], {})
    assert comparisons(history.series())[0].factor == "10 x better"


def test_without_a_ghost_a_note_tells_why_there_are_no_numbers() -> None:
    history = History()
    for i in range(100):
        history.add(beside(0.1 * i), [], {})
    assert comparisons(history.series()) == []
    assert "Waiting for the ghost" in comparison(beside(9.9), history, history.series(), 20.0)
    history.ghost.update(beside(9.9), [ghost(3.0)])
    assert "3 of 10 s" in comparison(beside(9.9), history, history.series(), 20.0)
    assert comparison(state(stamp=9.9), history, history.series(), 20.0) == ""


def test_names_from_elsewhere_are_escaped() -> None:
    hostile: Any = "<img src=x onerror=alert(1)>"
    history = compared(0.001, 0.01)
    assert "<img" not in comparison(replace(beside(30.0), controller=hostile), history, history.series(), 20.0)


def test_errors_below_a_micrometre_are_equal() -> None:
    assert Comparison("distance", 1e-5, 1e-4).factor == "the same"
