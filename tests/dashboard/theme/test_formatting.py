"""Laws of how numbers are written."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dashboard.page import Page
from dashboard.panels.robot_table import robot_table
from dashboard.panels.run_summary import run_summary
from dashboard.theme.formatting import error, length
from formation.scenario.files import load


@given(st.floats(-1.0, 1.0), st.floats(0.0, 0.1))
def test_an_error_has_a_number_unless_it_is_below_the_noise(metres: float, noise: float) -> None:
    assert error(metres, noise) == (("< noise", "") if abs(metres) < noise else length(metres))
    assert error(metres, 0.0) == length(metres)


@given(st.floats(-20.0, 20.0))
def test_a_length_has_one_decimal_below_ten_millimetres_and_none_above(metres: float) -> None:
    number, unit = length(metres)
    assert unit == "mm"
    if number == "< 0.1":
        assert 0.0 < abs(1e3 * metres) <= 0.05
    else:
        value = float(number)
        assert abs(value - 1e3 * metres) <= (0.5 if "." not in number else 0.05) + 1e-9
        assert ("." in number) == (abs(value) < 10.0)


@pytest.mark.parametrize(("sigma", "hidden"), [(0.0, False), (0.5, True)])
def test_tiles_and_robot_table_know_the_noise_of_the_bodies(page: Page, sigma: float, hidden: bool) -> None:
    snapshot, links, *_ = page._feed.now()
    scenario = load("triangle-circle", {"bodies": {"localisation": {"position": sigma}}})
    known = dataclasses.replace(snapshot, scenario=scenario)
    assert known.noise == sigma
    for html in (run_summary(known, links, []), robot_table(known, links, page._clickable)):
        assert ("&lt; noise" in html) == hidden
    assert dataclasses.replace(snapshot, scenario=None).noise == 0.0
