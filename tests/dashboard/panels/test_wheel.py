"""What a page may say of its keys."""

import pytest

from dashboard.panels.wheel import parse


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
