"""`echelon robots`: which robots stand at a router of ROS 2, and how each would be driven."""

import argparse
import json
from typing import Any

from rich.console import Console
from rich.table import Table

from ros.session import RosSession
from ros.spec import endpoint_of
from ros.survey import Found, robots_of
from ros.types import distribution


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("endpoint", metavar="ENDPOINT", help="the router, such as 10.0.0.11 or tcp/10.0.0.11:7447")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> int:
    """Print what is there; 1 if nothing is."""
    with RosSession(endpoint_of(options.endpoint), "echelon_robots") as session:
        found = robots_of(session.tokens())
    if options.json:
        print(json.dumps([_plain(robot) for robot in found], indent=2))
    elif found:
        _print(found)
    else:
        print("no node there subscribes to cmd_vel with Twist or TwistStamped")
    return 0 if found else 1


def _plain(robot: Found) -> dict[str, Any]:
    command = robot.command
    return {
        "namespace": robot.namespace,
        "domain": command.domain,
        "node": command.node,
        "topic": command.topic,
        "type": command.type,
        "hash": command.hash,
        "distribution": distribution(command.hash),
        "qos": command.quality,
        "poses": [{"topic": pose.topic, "type": pose.type} for pose in robot.poses],
    }


def _print(found: list[Found]) -> None:
    table = Table("commands", "type", "of", "QoS", "node", "poses")
    for robot in found:
        command = robot.command
        poses = "\n".join(f"{pose.topic} ({pose.type})" for pose in robot.poses) or "none"
        where = command.topic if command.domain == 0 else f"{command.topic} in domain {command.domain}"
        table.add_row(where, command.type, distribution(command.hash), command.quality, command.node, poses)
    Console(width=None if Console().is_terminal else 160).print(table)
