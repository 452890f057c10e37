"""Laws of what ROS 2 is shown: what the run says, in messages that somebody else's code reads, at its rate."""

from typing import Any

import numpy as np

from formation.scenario.files import load
from network.messages import State
from records.definitions import full_name, schema
from ros.display.node import MARKER_SECONDS, PATH_SECONDS, POSE_SECONDS, DisplayNode
from tests.builders import command, motion, state, status
from tests.exceptions import needs
from tests.records.reflection import decode

STAMP = 1_700_000_000_123_456_789
POSES = np.array([[0.0, 0.0, 0.5], [1.0, 0.0, -0.5], [0.0, 1.0, 3.0]])


def shown(node: DisplayNode, now: float = 10.0) -> dict[str, Any]:
    """By topic, the fields of what is published now, by the schema that records have."""
    return {one.topic: decode(schema(one.kind), full_name(one.kind), one.data) for one in node.show(now, STAMP)}


def whole(real: tuple[int, ...] = (), **changes: Any) -> DisplayNode:
    node = DisplayNode(real)
    node.take(state(poses=POSES, slots=POSES + 0.25, **changes))
    node.take(status(2, 1, plan=motion(100), believes=motion(99), age=0.5))
    node.take(command(2, 100, v=0.25, omega=-0.5))
    node.use(load("triangle-circle"))
    return node


def test_what_is_shown_is_what_the_run_says() -> None:
    found = shown(whole())
    frames = {one["child_frame_id"]: one["transform"] for one in found["/tf"]["transforms"]}
    assert frames.keys() == {"centre", *(f"{kind}{i}" for kind in ("robot", "slot") for i in (1, 2, 3))}
    assert frames["robot2"]["translation"] == {"x": 1.0, "y": 0.0, "z": 0.0}
    assert found["/robot2/odom"]["twist"]["twist"]["linear"]["x"] == 0.25
    assert found["/robot2/cmd_vel"]["twist"]["angular"]["z"] == -0.5
    assert found["/robot1/cmd_vel"]["twist"]["linear"]["x"] == 0.0  # nobody has commanded it
    assert len(found["/robot2/plan"]["poses"]) == 21
    markers = {one["ns"]: len(one["points"]) for one in found["/markers"]["markers"]}
    assert markers == {"edges": 6, "slots": 6, "links": 2, "plans": 40, "beliefs": 40, "path": 400}


def test_somebody_elses_code_reads_it_all() -> None:
    needs("rosbags")
    from rosbags.typesys import Stores, get_typestore

    for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_LYRICAL):
        types = get_typestore(store)
        for one in whole().show(10.0, STAMP):
            name = full_name(one.kind)
            found = types.deserialize_cdr(one.data, name)
            assert bytes(types.serialize_cdr(found, name)) == one.data, one.topic


def test_a_robot_that_does_not_move_is_shown_standing() -> None:
    for changes in ({"status": "paused"}, {"live": [1, 3]}, {"stopped": [2]}, {"episode": 4}):
        assert shown(whole(**changes))["/robot2/cmd_vel"]["twist"]["linear"]["x"] == 0.0


def test_a_real_robot_has_its_own_topics() -> None:
    found = shown(whole(real=(2,)))
    assert not {"/robot2/odom", "/robot2/cmd_vel"} & found.keys()
    assert {"/robot1/odom", "/robot3/cmd_vel", "/robot2/plan"} <= found.keys()


def test_each_kind_has_its_rate() -> None:
    node, times = whole(), np.arange(10.0, 20.0, POSE_SECONDS / 2.0)
    found = [shown(node, float(now)) for now in times]
    assert abs(sum("/tf" in one for one in found) - 10.0 / POSE_SECONDS) <= 2
    marked = [one["/markers"]["markers"] for one in found if "/markers" in one]
    assert abs(len(marked) - 10.0 / MARKER_SECONDS) <= 2
    assert abs(sum(len(one) == 6 for one in marked) - 10.0 / PATH_SECONDS) <= 2


def test_nothing_is_shown_before_there_is_a_state_and_nothing_of_an_earlier_episode() -> None:
    assert not DisplayNode().show(1.0, STAMP)
    node = whole()
    node.take(state(poses=POSES, slots=POSES, episode=5))
    assert not [topic for topic in shown(node) if topic.endswith(("plan", "belief"))]


def test_a_state_of_fewer_robots_hides_the_others() -> None:
    node = whole()
    fewer: State = state(1, poses=POSES[:1], slots=POSES[:1])
    node.take(fewer)
    assert not [topic for topic in shown(node) if topic.startswith(("/robot2", "/robot3"))]
