"""A robot of ROS 2 made of somebody else's code: `zenoh-ros2-sdk` of ROBOTIS, in a process of its own.

It subscribes to cmd_vel, drives as a unicycle, and publishes its odometry. Its message definitions come from rosbags'
types; the SDK itself would clone them from the network.

    python -m tests.ros.sdk_robot --port 7447 --namespace /robot2 --pose 0.75 -0.05 1.5
"""

import argparse
import json
import math
import tempfile
import time
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_typestore

PERIOD = 0.01
"""Between two poses [s]."""
WATCHDOG = 0.5
"""Without a command for so long it stands, as a TurtleBot3 does [s]."""


def define(folder: Path, *names: str) -> None:
    """Write the .msg file of every type that these are made of."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name in names:
        text, _ = store.generate_msgdef(name, ros_version=2)
        first, *others = text.split("=" * 80 + "\n")
        parts = [
            (name, first),
            *((part.split("\n", 1)[0].removeprefix("MSG: "), part.split("\n", 1)[1]) for part in others),
        ]
        for kind, definition in parts:
            package, *_, last = kind.split("/")
            file = folder / package / "msg" / f"{last}.msg"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(definition)


class SdkRobot:
    """A unicycle."""

    def __init__(self, port: int, namespace: str, pose: list[float], kind: str, watched: str) -> None:
        import zenoh_ros2_sdk as sdk

        folder = Path(tempfile.mkdtemp(prefix="msgs"))
        self.session = sdk.ZenohSession.get_instance("127.0.0.1", port)
        define(folder, f"geometry_msgs/msg/{kind}", "nav_msgs/msg/Odometry")
        sdk.get_registry(str(folder))
        self.pose, self.velocity, self.heard_at = list(pose), (0.0, 0.0), -math.inf
        where = {"router_port": port, "namespace": namespace}
        self.odometry = sdk.ROS2Publisher(f"{namespace}/odom", "nav_msgs/msg/Odometry", node_name="base", **where)
        self.commands = sdk.ROS2Subscriber(
            f"{namespace}/cmd_vel", f"geometry_msgs/msg/{kind}", self.obey, node_name="base", **where
        )
        self.made = self.session.store.types
        self.seen: list[float] = []
        """Where the odometry of another robot says that it is, and how fast."""
        if watched:
            self.watch = sdk.ROS2Subscriber(watched, "nav_msgs/msg/Odometry", self.see, node_name="eye", **where)
        self.known: list[Any] = []
        self.asked_at = -math.inf
        self.topics: Any = lambda: sdk.get_topic_names_and_types(router_port=port)

    def see(self, message: Any) -> None:
        place, twist = message.pose.pose.position, message.twist.twist
        self.seen = [place.x, place.y, twist.linear.x, twist.angular.z]

    def obey(self, message: Any) -> None:
        twist = getattr(message, "twist", message)
        self.velocity, self.heard_at = (twist.linear.x, twist.angular.z), time.monotonic()

    def step(self, dt: float) -> None:
        v, omega = self.velocity if time.monotonic() - self.heard_at < WATCHDOG else (0.0, 0.0)
        x, y, theta = self.pose
        middle = theta + 0.5 * omega * dt
        self.pose = [x + v * dt * math.cos(middle), y + v * dt * math.sin(middle), theta + omega * dt]

    def publish(self) -> None:
        made, (x, y, theta), (v, omega) = self.made, self.pose, self.velocity
        stamp = made["builtin_interfaces/msg/Time"](*divmod(time.time_ns(), 10**9))
        vector, nothing = made["geometry_msgs/msg/Vector3"], [0.0] * 36
        turn = made["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(theta / 2), math.cos(theta / 2))
        place = made["geometry_msgs/msg/Pose"](made["geometry_msgs/msg/Point"](x, y, 0.0), turn)
        twist = made["geometry_msgs/msg/Twist"](vector(v, 0.0, 0.0), vector(0.0, 0.0, omega))
        self.odometry.publish(
            header=made["std_msgs/msg/Header"](stamp, "odom"),
            child_frame_id="base_link",
            pose=made["geometry_msgs/msg/PoseWithCovariance"](place, _array(nothing)),
            twist=made["geometry_msgs/msg/TwistWithCovariance"](twist, _array(nothing)),
        )


def _array(values: list[float]) -> Any:
    import numpy as np

    return np.array(values)


def vars_of(robot: SdkRobot) -> dict[str, Any]:
    """What the test reads."""
    found = {"pose": robot.pose, "velocity": robot.velocity, "seen": robot.seen}
    if robot.seen and time.monotonic() - robot.asked_at > 1.0:
        robot.asked_at, robot.known = time.monotonic(), robot.topics()
    return {**found, "topics": robot.known}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--namespace", default="")
    parser.add_argument("--pose", type=float, nargs=3, required=True)
    parser.add_argument("--kind", default="TwistStamped")
    parser.add_argument("--watch", default="", help="odometry of another robot")
    parser.add_argument("--log", type=Path, help="a line of JSON a second: pose and velocity")
    options = parser.parse_args()
    robot = SdkRobot(options.port, options.namespace, options.pose, options.kind, options.watch)
    due, said = time.monotonic(), 0.0
    while True:
        due += PERIOD
        time.sleep(max(0.0, due - time.monotonic()))
        robot.step(PERIOD)
        robot.publish()
        if time.monotonic() - said > 0.1:
            said = time.monotonic()
            if options.log:
                half = options.log.with_suffix(".half")  # a robot that is killed leaves a whole file
                half.write_text(json.dumps(vars_of(robot)))
                half.replace(options.log)


if __name__ == "__main__":
    main()
