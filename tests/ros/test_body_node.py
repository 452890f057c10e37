"""Laws of a real robot's body: it stands unless the run has just said otherwise, and is never silent for long."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.bodies import BodyInput
from records import messages
from ros.body.node import INPUT_SECONDS, LEAST_SECONDS, REPEAT_SECONDS, STILL, BodyNode
from ros.spec import parse
from ros.types import ODOMETRY, POSE_STAMPED

SPEC = parse("2=tcp/h:1,origin=1:2:90")
STEP = 0.01
LONGEST = 0.1
"""Commands are at least as often: 10 Hz [s]."""


def said(v: float, omega: float = 0.0) -> BodyInput:
    return BodyInput(0, 1, 0.01, 5, v, omega)


@given(st.lists(st.booleans(), min_size=1, max_size=120))
def test_a_command_is_the_newest_input_or_zero_and_never_rare(speaks: list[bool]) -> None:
    node, now, heard_at, sent = BodyNode(SPEC), 100.0, -1.0, [100.0]
    for k, speaking in enumerate(speaks, 1):
        now += STEP
        if speaking:
            node.hear(said(float(k)), now)
            heard_at, newest = now, float(k)
        command = node.command(now)
        if command is not None:
            fresh = now - heard_at <= INPUT_SECONDS
            assert command == ((newest, 0.0) if fresh else STILL)
            sent.append(now)
    gaps = np.diff([*sent, now])
    assert max(gaps) <= REPEAT_SECONDS + STEP + 1e-6 < LONGEST
    assert min(gaps[1:-1], default=1.0) >= LEAST_SECONDS - 2e-3


def test_a_pose_is_told_in_the_formations_map_with_its_age() -> None:
    node = BodyNode(SPEC)
    node.begin(ODOMETRY)
    (data,) = messages.odometries(1, ["b"], np.array([[3.0, 0.0, 0.25]]), np.array([[0.5, -1.0]]))
    found = node.locate(data, 10.0, 10.125)
    assert found is not None
    assert found.pose == pytest.approx([1.0, 5.0, np.pi / 2 + 0.25])
    assert (found.sender, found.age, *found.velocity) == (2, 0.125, 0.5, -1.0)


def test_a_robot_that_does_not_say_how_fast_it_is_is_as_fast_as_commanded() -> None:
    node = BodyNode(SPEC)
    node.begin(POSE_STAMPED)
    node.hear(said(0.25, 0.5), 10.0)
    data = messages.path(1, np.zeros((1, 3)), [1])
    single = b"\x00\x01\x00\x00" + data[4 + 20 :]
    found = node.locate(single, 10.0, 10.0)
    assert found is not None
    assert found.velocity.tolist() == [0.25, 0.5]
    assert (found.episode, found.stamp) == (5, 0.01)


def test_what_cannot_be_read_is_counted_and_moves_nothing() -> None:
    node = BodyNode(SPEC)
    node.begin(ODOMETRY)
    assert node.locate(b"\x00\x01\x00\x00rubbish", 0.0, 0.0) is None
    assert node.rejected == 1
