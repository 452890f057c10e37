"""Laws of names, tokens and types: what is written is read, and hashes are those of another implementation."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros import tokens
from ros.spec import parse
from ros.survey import choose, robots_of
from ros.tokens import DEFAULT_QOS, Endpoint
from ros.types import HASHES, NO_HASH, ODOMETRY, POSE_STAMPED, TF, TWIST, TWIST_STAMPED, distribution
from tests.exceptions import needs

NAMES = st.from_regex(r"(/[a-z_][a-z0-9_]{0,5}){1,3}", fullmatch=True)
ENDPOINTS = st.builds(
    Endpoint,
    st.integers(0, 232),
    st.sampled_from(["MP", "MS"]),
    NAMES,
    st.from_regex(r"[a-z_]{1,8}", fullmatch=True),
    NAMES,
    st.sampled_from(list(HASHES)),
    st.sampled_from([NO_HASH, *HASHES.values()]),
    st.just(DEFAULT_QOS),
)
CAPTURED = (
    "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MS/%/%/turtlebot3_node/%cmd_vel/"
    "geometry_msgs::msg::dds_::TwistStamped_/RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64/"
    "2:1:,5:,:,:,,"
)


@given(ENDPOINTS, st.integers(1, 99))
def test_a_token_is_read_as_it_was_written(endpoint: Endpoint, entity: int) -> None:
    assert tokens.read(tokens.write(endpoint, "a1b2", entity)) == endpoint


@given(st.text(max_size=60) | st.lists(st.text(max_size=8), min_size=13, max_size=13).map("/".join))
def test_any_text_is_a_token_or_none(text: str) -> None:
    tokens.read(text)
    tokens.read(f"@ros2_lv/{text}")


def test_a_token_says_what_the_robot_wants() -> None:
    found = tokens.read(CAPTURED)
    assert found is not None
    assert (found.topic, found.type, found.namespace, found.node) == ("/cmd_vel", TWIST_STAMPED, "/", "turtlebot3_node")
    assert found.quality == "best effort, transient local, keep last 5"
    assert found.key == f"0/cmd_vel/geometry_msgs::msg::dds_::TwistStamped_/{HASHES[TWIST_STAMPED]}"
    assert (distribution(found.hash), distribution(NO_HASH)) == ("Iron or newer", "Humble")


def test_hashes_are_those_of_another_implementation_in_every_distribution() -> None:
    needs("rosbags")
    from rosbags.typesys import Stores, get_typestore

    for store in (Stores.ROS2_IRON, Stores.ROS2_JAZZY, Stores.ROS2_KILTED, Stores.ROS2_LYRICAL):
        types = get_typestore(store)
        for name, known in HASHES.items():
            assert types.hash_rihs01(name.replace("/", "/msg/")) == known, (store, name)


def endpoint(kind: Any, topic: str, what: str, domain: int = 0) -> str:
    return tokens.write(Endpoint(domain, kind, "/", "node", topic, what, HASHES[what], DEFAULT_QOS), "zid", 1)


STANDING = [
    endpoint("MS", "/robot1/cmd_vel", TWIST),
    endpoint("MP", "/robot1/odom", ODOMETRY),
    endpoint("MP", "/mocap/robot1", POSE_STAMPED),
    endpoint("MS", "/robot2/cmd_vel", TWIST_STAMPED),
    endpoint("MP", "/robot2/odom", ODOMETRY),
    endpoint("MP", "/robot2/pose", POSE_STAMPED),
    endpoint("MP", "/tf", TF),
    endpoint("MP", "/robot9/cmd_vel", TWIST),  # somebody's joystick, no robot
]


def test_a_robot_is_who_listens_to_cmd_vel_and_its_best_pose_comes_first() -> None:
    found = {robot.namespace: robot for robot in robots_of(STANDING)}
    assert {name: robot.command.type for name, robot in found.items()} == {"/robot1": TWIST, "/robot2": TWIST_STAMPED}
    assert [pose.topic for pose in found["/robot2"].poses] == ["/robot2/pose", "/robot2/odom", "/tf"]


@pytest.mark.parametrize(
    ("words", "topic"),
    [
        ("namespace=/robot1", "/robot1/odom"),
        ("namespace=/robot2", "/robot2/pose"),
        ("namespace=/robot2,pose=/odom", "/robot2/odom"),
        ("namespace=/robot2,pose=/tf", "/tf"),
    ],
)
def test_the_pose_is_the_named_topic_or_the_best(words: str, topic: str) -> None:
    assert choose(parse(f"1=tcp/h:1,{words}"), robots_of(STANDING)).pose.topic == topic
