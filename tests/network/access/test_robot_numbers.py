"""Laws of robots' numbers as users write them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.errors import EchelonError
from formation.schema import MAX_ROBOTS
from network.access.keys import host_and_port
from network.access.robot_numbers import parsed, spelled


@given(st.sets(st.integers(1, MAX_ROBOTS), min_size=1))
def test_what_is_spelled_is_read_as_the_same(robots: set[int]) -> None:
    assert parsed(spelled(robots)) == robots


def test_spelling_is_short() -> None:
    assert spelled({1, 2, 3, 5, 7, 8}) == "1-3,5,7-8"


@pytest.mark.parametrize(
    "text", ["", "0", str(MAX_ROBOTS + 1), "a", "1-", "-1", "3-1", "1,,2", "1-2-3", "\uff19", "1e1", "9" * 5000]
)
def test_what_is_no_list_of_robots_is_refused_in_a_line(text: str) -> None:
    with pytest.raises(EchelonError, match="expected"):
        parsed(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10.0.0.5", ("10.0.0.5", 7447)),
        ("a-host:80", ("a-host", 80)),
        ("::1", ("::1", 7447)),
        ("[fe80::1]:5", ("fe80::1", 5)),
    ],
)
def test_a_host_may_have_a_port(text: str, expected: tuple[str, int]) -> None:
    assert host_and_port(text) == expected


@pytest.mark.parametrize("text", ["", ":1", "a:b", "a:0", "a:65535", "a:99999", "a/b", "u@a", "[::1", "tls/a:1", "a?b"])
def test_what_is_no_host_is_refused_in_a_line(text: str) -> None:
    with pytest.raises(EchelonError, match="HOST"):
        host_and_port(text)
