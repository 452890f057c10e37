"""Laws of runs with real robots: one of another make takes its place like any other, and always is told to stand."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from network import topics
from network.bodies import BodyInput, BodyPose
from network.bus import Sample
from network.codec import decode
from network.messages import State
from network.zenoh_bus import ZenohBus
from records.cdr import Fields
from ros.types import TWIST
from runtime.run_registry import find
from tests.processes.live import Up, wait_for
from tests.ros.peers import Robot, SdkRobot, router

pytestmark = pytest.mark.processes
CLOSE = 0.005
"""[m]."""


class Watcher:
    """The newest State of a run."""

    def __init__(self, bus: ZenohBus) -> None:
        self._bus = bus
        self._state: State | None = None
        bus.subscribe(topics.state(bus.run))

    def state(self) -> State:
        wait_for(self._look)
        assert self._state is not None
        return self._state

    def _look(self) -> bool:
        found = [item for item in self._bus.arrivals(0.2) if isinstance(item, Sample)]
        if found:
            self._state = decode(State, found[-1].payload)
        return bool(found)

    def error(self) -> float:
        """The largest distance error now [m]; infinite if a robot does not take part."""
        state = self.state()
        whole = state.live == [1, 2, 3] and not state.stopped and state.stamp > 0.5
        return float(np.abs(state.distance_errors).max()) if whole else np.inf


def test_a_robot_of_another_make_takes_its_place_like_any_other(up: Callable[..., Up], tmp_path: Path) -> None:
    with router() as endpoint:
        robot = SdkRobot(endpoint, tmp_path, [0.7, -0.05, 1.5], "/robot1/odom")  # 5 cm from its start
        live = up("--no-dashboard", "--robot", f"2={endpoint},namespace=/robot2", "--ros", endpoint)
        wait_for(lambda: "running triangle-circle" in live.text())
        with ZenohBus(find("test").endpoint, "test") as bus:
            watcher = Watcher(bus)
            wait_for(lambda: watcher.error() < CLOSE)
            until = watcher.state().stamp + 2.0
            while watcher.state().stamp < until:  # and stays
                assert watcher.error() < CLOSE
            _sees_the_others(robot, watcher)
            robot.kill()
            wait_for(lambda: watcher.state().waiting_for == [2])
            assert "robot 2 is lost: no pose for 0.5 s" in [event.text for event in watcher.state().events]
            lost_at = watcher.state().stamp
            wait_for(lambda: watcher.state().stamp > lost_at + 1.0)  # the others go on
            robot.start(robot.state["pose"])
            wait_for(lambda: watcher.error() < CLOSE)
            assert "robot 2 is back" in [event.text for event in watcher.state().events]
        wait_for(lambda: robot.state["velocity"][0] > 0.0)
        os.kill(live.process.pid, signal.SIGKILL)
        wait_for(lambda: robot.state["velocity"] == [0.0, 0.0])
        robot.kill()


def _sees_the_others(robot: SdkRobot, watcher: Watcher) -> None:
    """As robots of ROS 2, by somebody else's code."""
    state = wait_for(lambda: (found := robot.state)["topics"] and found)
    assert state["seen"][:2] == pytest.approx(watcher.state().poses[0, :2], abs=0.05)
    assert state["seen"][2] > 0.0
    kinds = dict(state["topics"])
    for i in (1, 3):
        assert kinds[f"/robot{i}/odom"] == ["nav_msgs/msg/Odometry"]
        assert kinds[f"/robot{i}/cmd_vel"] == ["geometry_msgs/msg/TwistStamped"]
        assert kinds[f"/robot{i}/plan"] == kinds[f"/robot{i}/belief"] == ["nav_msgs/msg/Path"]
    assert kinds["/tf"] == ["tf2_msgs/msg/TFMessage"]
    assert kinds["/markers"] == ["visualization_msgs/msg/MarkerArray"]


def _speeds(heard: list[bytes]) -> list[float]:
    return [float(Fields(data).array("d", 6)[0]) for data in heard]


def _serve(endpoint: str) -> None:
    from network.__main__ import main

    main(["--listen", endpoint])


def test_a_robot_is_told_to_stand_whatever_ends(runs: Path) -> None:
    """The run falls silent, its router dies, the body's process is asked to end."""
    ours = f"unixsock-stream/{runs}/r"
    with router() as theirs:
        robot = Robot(theirs, "/r", (1.0, 2.0, 0.5), kind=TWIST)
        our_router = multiprocessing.get_context("spawn").Process(target=_serve, args=(ours,))
        our_router.start()
        words = ["--run", "test", "--connect", ours, "--robot", f"2={theirs},namespace=/r"]
        body = subprocess.Popen([sys.executable, "-m", "ros.body", *words])
        try:
            with ZenohBus(ours, "test") as bus:
                key = topics.body_input(bus.run, 2)
                bus.announce(key)
                bus.subscribe(topics.body_pose(bus.run, 2))

                def drive(seconds: float) -> None:
                    until = time.monotonic() + seconds
                    while time.monotonic() < until:
                        bus.publish(key, BodyInput(0, 1, 1.0, 7, 0.25, 0.0))
                        time.sleep(0.02)

                def moving() -> bool:
                    drive(0.1)
                    return _speeds(robot.heard[-1:]) == [0.25]

                wait_for(moving)
                poses = [decode(BodyPose, item.payload) for item in bus.arrivals() if isinstance(item, Sample)]
                assert poses[-1].pose == pytest.approx([1.0, 2.0, 0.5])
                assert poses[-1].episode == 7
                assert {len(found) for found in robot.attachments} == {33}
                wait_for(lambda: _speeds(robot.heard[-1:]) == [0.0])  # silent
                wait_for(moving)
                our_router.kill()
                wait_for(lambda: _speeds(robot.heard[-1:]) == [0.0])
                count = len(robot.heard)
                time.sleep(0.5)
                assert len(robot.heard) - count >= 5  # at 10 Hz or more, for the robot's own watchdog
                our_router = multiprocessing.get_context("spawn").Process(target=_serve, args=(ours,))
                our_router.start()
                wait_for(moving)
                body.send_signal(signal.SIGTERM)
                assert body.wait(10) == 0
                assert _speeds(robot.heard[-2:]) == [0.0, 0.0]
        finally:
            body.kill()
            body.wait(10)
            our_router.kill()
            our_router.join(10)
            robot.close()
