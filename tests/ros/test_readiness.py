"""Laws of starting with real robots: what cannot work is refused in one line, what stands there is listed."""

import json
from collections.abc import Iterator
from typing import Any

import pytest

from cli.main import main
from formation.scenario.files import load
from ros import readiness
from ros.spec import parse_all
from ros.types import NO_HASH, TWIST
from tests.ros.peers import Robot, free_port, router

UP = ("up", "triangle-circle", "--no-dashboard", "--robot")


@pytest.fixture(scope="module")
def standing() -> Iterator[str]:
    """A router with three robots: one of Humble that wants Twist, one that says nothing, one in the way of robot 1."""
    with router() as endpoint:
        robots = [
            Robot(endpoint, "/good", (0.75, -0.05, 1.5), kind=TWIST, type_hash=NO_HASH),
            Robot(endpoint, "/silent", says=False),
            Robot(endpoint, "/close", (0.8, 0.065, 1.5)),
        ]
        yield endpoint
        for robot in robots:
            robot.close()


def test_robots_are_listed(standing: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", standing, "--json"]) == 0
    found = {robot["namespace"]: robot for robot in json.loads(capsys.readouterr().out)}
    assert list(found) == ["/close", "/good", "/silent"]
    good = found["/good"]
    assert (good["type"], good["distribution"], good["qos"]) == (TWIST, "Humble", "reliable, volatile, keep last 10")
    assert good["poses"] == [{"topic": "/good/odom", "type": "nav_msgs/Odometry"}]
    assert main(["robots", standing]) == 0
    assert "Humble" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("namespace=/nobody", "subscribes to /nobody/cmd_vel"),
        ("namespace=/good,pose=/mocap", "expected /mocap at"),
        ("namespace=/silent", "expected a pose on /silent/odom at least every 0.5 s"),
        ("namespace=/close", "expected the poses of robots 2 and 1 at least 0.07 m apart"),
        ("namespace=/good,domain=3", "in domain 3; there is none"),
    ],
)
def test_a_robot_that_cannot_take_part_is_refused_in_one_line(
    words: str, reason: str, standing: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*UP, f"2={standing},{words}"]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert reason in line


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["2=tcp/127.0.0.1:{port}"], "robot 2: expected a router of ROS 2 at"),
        (["2=nonsense/x"], "robot 2: expected"),
        (["2=tcp/127.0.0.1:{port}", "--speed", "2"], "--speed: expected 1"),
        (["2=tcp/127.0.0.1:{port}", "--set", "bodies.radius=0.06"], "expected the slots at the start of robots 2 and"),
        (["2=tcp/127.0.0.1:{port}", "--bodies", "mujoco:ideal"], "expected"),
    ],
)
def test_what_cannot_work_is_refused_before_anything_starts(
    words: list[str], reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*UP, *(word.format(port=free_port()) for word in words)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert reason in lines[-1]


def test_a_robot_that_can_take_part_is_looked_at(standing: str) -> None:
    scenario: Any = load("triangle-circle")
    found = readiness.check(scenario, parse_all([f"2={standing},namespace=/good"], 3))
    assert found[2].command.type == TWIST
    assert found[2].pose.topic == "/good/odom"
