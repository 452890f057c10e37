"""Routers and robots of ROS 2 for tests: in this process, and of another make in a process of its own."""

import contextlib
import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import zenoh

from network.zenoh_bus import Router
from records import messages
from ros import tokens
from ros.session import RosSession
from ros.tokens import DEFAULT_QOS, Endpoint
from ros.types import HASHES, ODOMETRY, TWIST_STAMPED
from tests.exceptions import needs
from tests.processes.live import _die_with_parent, wait_for


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def router() -> Iterator[str]:
    """A plain router, as robots have one; its endpoint."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    session = Router([endpoint], insecure=True)
    try:
        yield endpoint
    finally:
        session.close()


class Robot:
    """A robot in this process: it stands, says where it is, and keeps what it was commanded."""

    def __init__(
        self,
        endpoint: str,
        namespace: str = "",
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        kind: str = TWIST_STAMPED,
        type_hash: str = "",
        says: bool = True,
    ) -> None:
        self.session = RosSession(endpoint, "base")
        self.heard: list[bytes] = []
        self.attachments: list[bytes] = []
        self._odometry = self.session.publisher(f"{namespace}/odom", ODOMETRY, type_hash)
        where = Endpoint(0, "MS", "/", "base", f"{namespace}/cmd_vel", kind, type_hash or HASHES[kind], DEFAULT_QOS)
        inner = self.session._session
        token = tokens.write(where, str(inner.info.zid()), 7)
        self._kept = [
            inner.liveliness().declare_token(token),
            inner.declare_subscriber(where.any_hash, zenoh.handlers.Callback(self._hear, indirect=False)),
        ]
        self._pose, self._over = np.array(pose), threading.Event()
        self._thread = threading.Thread(target=self._say, daemon=True)
        if says:
            self._thread.start()

    def _hear(self, sample: zenoh.Sample) -> None:
        assert sample.attachment is not None
        self.attachments.append(bytes(sample.attachment.to_bytes()))
        self.heard.append(bytes(sample.payload.to_bytes()))

    def _say(self) -> None:
        while not self._over.wait(0.02):
            self._odometry.put(*messages.odometries(time.time_ns(), ["base_link"], self._pose[None], np.zeros((1, 2))))

    def close(self) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()
        self.session.close()


class SdkRobot:
    """The robot of tests/ros/sdk_robot.py."""

    def __init__(self, endpoint: str, folder: Path, pose: list[float], watched: str) -> None:
        needs("rosbags", "zenoh-ros2-sdk")
        self._file = folder / "robot.json"
        self._words = [sys.executable, "-m", "tests.ros.sdk_robot", "--port", endpoint.rpartition(":")[2]]
        self._words += ["--namespace", "/robot2", "--log", str(self._file), "--watch", watched]
        self._folder = folder
        self.start(pose)

    def start(self, pose: list[float]) -> None:
        self._file.unlink(missing_ok=True)
        with (self._folder / "robot.out").open("w") as out:
            self._process = subprocess.Popen(
                [*self._words, "--pose", *map(str, pose)],
                stdout=out,
                stderr=subprocess.STDOUT,
                env={**os.environ, "ZENOH_ROS2_SDK_CACHE": str(self._folder / "none")},
                preexec_fn=_die_with_parent,  # noqa: PLW1509  it only makes one system call
            )
        wait_for(self._file.exists)

    @property
    def state(self) -> dict[str, Any]:
        """Its pose, and the velocity that it was commanded."""
        return dict(wait_for(self._read))

    def _read(self) -> dict[str, Any]:
        with contextlib.suppress(json.JSONDecodeError):
            return dict(json.loads(self._file.read_text()))
        return {}

    def kill(self) -> None:
        """At once, like a robot whose battery is empty."""
        self._process.kill()
        self._process.wait(10)
