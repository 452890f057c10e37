"""What a page may say of its keys."""

import pytest

from dashboard.steering.wheel import parse
from dashboard.theme.templates import render
from formation.scenario.files import load
from network.values import Driving


@pytest.mark.parametrize(
    ("text", "held"), [("1,0,17", (1.0, 0.0)), ("-1,1,2e12", (-1.0, 1.0)), ("9e9,-7,0", (1.0, -1.0))]
)
def test_held_keys_are_shares_within_one(text: str, held: tuple[float, float]) -> None:
    assert parse(text) == held


@pytest.mark.parametrize(
    "text", ["", "1,0", "1,0,1,1", "nan,0,1", "0,inf,1", "a,b,c", "1" * 100 + ",0,0", None, 3, ["1,0,1"]]
)
def test_anything_else_holds_no_key(text: object) -> None:
    assert parse(text) is None


def test_the_panel_tells_what_is_ordered_and_who_has_the_wheel() -> None:
    driving, law = Driving(2, 0.1, -0.2, (0.5, 0.25)), load("drive-me").law
    text = render("steering/driving.html", driving=driving, goal=driving.goal, law=law, page=3)
    for words in ("0.10 of 0.34 m/s", "-0.20 of 1.00 rad/s", "goes to 0.50, 0.25 m", "page 3"):
        assert words in text
