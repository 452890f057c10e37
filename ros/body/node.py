"""A real robot's body without any I/O: poses and inputs in, a pose for the world and a command for the robot out.

It reads no clock: `now` is monotonic wall-clock time [s] everywhere.
"""

import numpy as np

from formation.arrays import frozen
from network.bodies import BodyInput, BodyPose
from ros.decoding import PoseReader
from ros.spec import RobotSpec

INPUT_SECONDS = 0.2
"""An input that is older is not acted on: the robot is told to stand [s]."""
REPEAT_SECONDS = 0.05
"""A command is published at least as often [s]: watchdogs of bases stop a robot after 0.25 to 1 s of silence."""
LEAST_SECONDS = 0.02
"""And at most as often [s]."""
STILL = (0.0, 0.0)


class BodyNode:
    """Between a run and one robot."""

    def __init__(self, spec: RobotSpec) -> None:
        self._spec = spec
        self._reader: PoseReader | None = None
        self._input: BodyInput | None = None
        self._input_at = -np.inf
        self._sent_at = -np.inf
        self._sent = STILL
        self._poses = 0
        self.rejected = 0
        """Messages of the robot that could not be read."""

    def begin(self, kind: str) -> None:
        """Poses come as messages of this type from now on."""
        self._reader = PoseReader(kind, self._spec.namespace)

    def hear(self, message: BodyInput, now: float) -> None:
        """The world says what to do."""
        self._input, self._input_at = message, now

    def locate(self, data: bytes, came: float, now: float) -> BodyPose | None:
        """The robot says where it is; what the world is told of it.

        Args:
            data: of its message.
            came: when it came in [s].
            now: [s].
        """
        if self._reader is None:
            return None
        try:
            found = self._reader.read(data)
        except ValueError:
            self.rejected += 1
            return None
        if found is None:
            return None
        self._poses += 1
        heard = self._input
        return BodyPose(
            sender=self._spec.number,
            seq=self._poses,
            stamp=heard.stamp if heard else 0.0,
            episode=heard.episode if heard else 0,
            pose=frozen(self._spec.origin.then(found.place)),
            velocity=frozen(self.wanted(now) if found.speed is None else found.speed),
            age=max(0.0, now - came),
        )

    def wanted(self, now: float) -> tuple[float, float]:
        """v, omega that the robot is to have [m/s, rad/s]: zeros unless the run has just said otherwise."""
        if self._input is None or now - self._input_at > INPUT_SECONDS:
            return STILL
        return self._input.v, self._input.omega

    def command(self, now: float) -> tuple[float, float] | None:
        """What to publish now [m/s, rad/s]; None if it is not time yet."""
        since, wanted = now - self._sent_at, self.wanted(now)
        if since < (LEAST_SECONDS if wanted != self._sent else REPEAT_SECONDS) - 1e-3:
            return None
        self._sent_at, self._sent = now, wanted
        return wanted
