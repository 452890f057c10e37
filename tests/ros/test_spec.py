"""Laws of what --robot takes: what is printed is read again, and a mistake is one line with what was expected."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.errors import EchelonError
from ros.decoding import Place
from ros.spec import RobotSpec, endpoint_of, parse, parse_all

NUMBERS = st.floats(-1e6, 1e6)


@given(
    st.builds(
        RobotSpec,
        st.integers(1, 64),
        st.just("tcp/h:7447"),
        st.sampled_from(["", "/a/b"]),
        st.sampled_from(["", "/odom"]),
        st.builds(Place, NUMBERS, NUMBERS, st.just(0.0)),
        st.integers(0, 232),
    )
)
def test_a_spec_is_read_as_it_was_written(spec: RobotSpec) -> None:
    assert parse(str(spec)) == spec


@pytest.mark.parametrize(
    ("text", "endpoint"),
    [
        ("10.0.0.11", "tcp/10.0.0.11:7447"),
        ("robot:7", "tcp/robot:7"),
        ("udp/h:1", "udp/h:1"),
        ("[::1]", "tcp/[::1]:7447"),
    ],
)
def test_an_address_alone_is_an_endpoint(text: str, endpoint: str) -> None:
    assert endpoint_of(text) == endpoint


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1",
        "1=",
        "x=tcp/h:1",
        "0=h",
        "1=h,namespace=",
        "1=h,name=/a",
        "1=h,domain=233",
        "1=h,domain=x",
        "1=h,origin=1:2",
        "1=h,origin=a:b:c",
        "1=h,origin=1:2:nan",
        "1=h,pose=/a b",
        "1=namespace=/a",
    ],
)
def test_a_mistake_is_one_line_with_what_was_expected(text: str) -> None:
    with pytest.raises(EchelonError, match=r"^--robot[^\n]*expected[^\n]*$"):
        parse(text)


@pytest.mark.parametrize("texts", [["4=h"], ["1=h", "1=g"]])
def test_each_robot_is_one_of_the_scenario_and_named_once(texts: list[str]) -> None:
    with pytest.raises(EchelonError, match="expected"):
        parse_all(texts, 3)
