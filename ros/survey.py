"""What stands at a router of ROS 2: robots, by the tokens of their subscriptions to cmd_vel."""

from collections.abc import Iterable
from typing import NamedTuple

from formation.errors import EchelonError
from ros import tokens
from ros.spec import RobotSpec
from ros.tokens import Endpoint
from ros.types import COMMANDS, POSES, TF

COMMAND_TOPIC = "cmd_vel"


class Found(NamedTuple):
    """A robot."""

    namespace: str
    """Of its topics; empty for none."""
    command: Endpoint
    """Its subscription to cmd_vel."""
    poses: list[Endpoint]
    """What says where it is, the best first."""


class Chosen(NamedTuple):
    """How a robot is driven."""

    command: Endpoint
    pose: Endpoint


def robots_of(texts: Iterable[str]) -> list[Found]:
    """Every robot that these tokens tell of, in the order of their names."""
    endpoints = [endpoint for text in texts if (endpoint := tokens.read(text))]
    found: dict[tuple[int, str], Found] = {}
    for endpoint in sorted(endpoints):
        space, _, last = endpoint.topic.rpartition("/")
        if endpoint.kind == "MS" and last == COMMAND_TOPIC and endpoint.type in COMMANDS:
            found.setdefault(
                (endpoint.domain, space), Found(space, endpoint, _poses(endpoints, endpoint.domain, space))
            )
    return list(found.values())


def _poses(endpoints: list[Endpoint], domain: int, space: str) -> list[Endpoint]:
    own = [
        one
        for one in endpoints
        if one.kind == "MP" and one.domain == domain and one.type in POSES
        if one.topic.startswith(f"{space}/") or (one.type == TF and one.topic == "/tf")
    ]
    return sorted({one.topic: one for one in own}.values(), key=lambda one: (POSES.index(one.type), one.topic))


def choose(spec: RobotSpec, robots: list[Found]) -> Chosen:
    """The topics of a robot. Raises EchelonError: it is not there, or says nowhere where it is."""
    here = [robot for robot in robots if robot.command.domain == spec.domain]
    robot = next((robot for robot in here if robot.namespace == spec.namespace), None)
    if robot is None:
        there = ", ".join(robot.command.topic for robot in here) or "none"
        raise EchelonError(
            f"robot {spec.number}: expected a node at {spec.endpoint} that subscribes to "
            f"{spec.namespace}/{COMMAND_TOPIC} with {' or '.join(COMMANDS)} in domain {spec.domain}; there is {there}"
        )
    wanted = [spec.pose, f"{spec.namespace}{spec.pose}"] if spec.pose else [one.topic for one in robot.poses[:1]]
    everywhere = {one.topic: one for other in (robot, *here) for one in other.poses}
    pose = next((everywhere[topic] for topic in wanted if topic in everywhere), None)
    if pose is None:
        topic = spec.pose or "a topic"
        there = ", ".join(one.topic for one in robot.poses) or "none"
        raise EchelonError(
            f"robot {spec.number}: expected {topic} at {spec.endpoint} that says where it is ({', '.join(POSES)}); "
            f"there is {there}"
        )
    return Chosen(robot.command, pose)
