"""What ROS 2 is shown of a run, without any I/O: messages of the run in, messages of ROS 2 out.

It reads no clock: the caller says when it is, in seconds for rates and in nanoseconds since the epoch for stamps.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray
from formation.link_ids import LinkId
from formation.scenario.scenario import Scenario
from formation.unicycle import roll_out
from network.messages import Command, State, Status
from network.values import Motion
from records import messages, pictures
from ros.types import MARKERS, ODOMETRY, PATH, TF, TWIST_STAMPED

POSE_SECONDS, MARKER_SECONDS, PATH_SECONDS = 0.05, 0.1, 1.0
"""Between two messages of poses, of markers, and of those with the whole path [s of wall clock]."""
PATH_POINTS = 201
STILL: FloatArray = np.zeros(2)


class Shown(NamedTuple):
    """A message of ROS 2."""

    topic: str
    kind: str
    data: bytes


class DisplayNode:
    """Robots, slots, plans, beliefs and links of a run."""

    def __init__(self, real: Iterable[int] = ()) -> None:
        """Nothing to show yet.

        Args:
            real: robots that are real: ROS 2 has their odometry and commands already.
        """
        self._real = frozenset(real)
        self._state: State | None = None
        self._path: FloatArray = np.zeros((0, 2))
        self._statuses: dict[int, Status] = {}
        self._commands: dict[int, Command] = {}
        self._posed_at = self._marked_at = self._drawn_at = -np.inf

    @property
    def version(self) -> tuple[int, int] | None:
        """Episode and revision of the scenario that the state is of; None before the first state."""
        return (self._state.episode, self._state.revision) if self._state else None

    def use(self, scenario: Scenario) -> None:
        """The scenario that the state is of."""
        if scenario.driven:
            self._path = np.zeros((0, 2))
            return
        period = scenario.path.period
        end = scenario.duration if period is None else period
        self._path = scenario.path.position(np.linspace(0.0, end, PATH_POINTS))

    def take(self, message: State | Status | Command) -> None:
        """A message of the run."""
        match message:
            case State():
                if self._state is not None and self._state.episode != message.episode:
                    self._statuses.clear()
                    self._commands.clear()
                self._state = message
            case Status():
                self._statuses[message.sender] = message
            case Command():
                self._commands[message.sender] = message

    def show(self, now: float, stamp: int) -> list[Shown]:
        """What is to be published now [s]; stamped [ns since the epoch]."""
        state = self._state
        if state is None:
            return []
        found: list[Shown] = []
        if now - self._posed_at >= POSE_SECONDS - 1e-3:
            self._posed_at = now
            found += self._poses(state, stamp)
        if now - self._marked_at >= MARKER_SECONDS - 1e-3:
            self._marked_at = now
            whole = now - self._drawn_at >= PATH_SECONDS - 1e-3
            self._drawn_at = now if whole else self._drawn_at
            found += self._plans(state, stamp)
            found.append(Shown("/markers", MARKERS, messages.markers(stamp, self._markers(state, path=whole))))
        return found

    def _poses(self, state: State, stamp: int) -> list[Shown]:
        n = len(state.poses)
        frames = messages.frames(n)
        placed = np.vstack([state.poses, state.slots, state.centre])
        found = [Shown("/tf", TF, messages.transforms(stamp, frames, placed))]
        simulated = [i for i in range(1, n + 1) if i not in self._real]
        robots = [frames[i - 1] for i in simulated]
        poses = np.array([state.poses[i - 1] for i in simulated]).reshape(-1, 3)
        velocities = np.array([self._velocity(state, i) for i in simulated]).reshape(-1, 2)
        moved = messages.odometries(stamp, robots, poses, velocities)
        commanded = messages.twists_stamped(stamp, robots, velocities)
        for robot, odometry, twist in zip(robots, moved, commanded, strict=True):
            found.append(Shown(f"/{robot}/odom", ODOMETRY, odometry))
            found.append(Shown(f"/{robot}/cmd_vel", TWIST_STAMPED, twist))
        return found

    def _velocity(self, state: State, robot: int) -> FloatArray:
        """What a robot is commanded; zeros if nobody moves it."""
        command = self._commands.get(robot)
        moves = state.status == "running" and robot in state.live and robot not in state.stopped
        if command is None or command.episode != state.episode or not moves:
            return STILL
        return np.array([command.v, command.omega])

    def _current(self, state: State) -> list[Status]:
        here = range(1, len(state.poses) + 1)
        return [one for robot, one in self._statuses.items() if robot in here and one.episode == state.episode]

    def _plans(self, state: State, stamp: int) -> list[Shown]:
        found = []
        for status in self._current(state):
            for name, motion in (("plan", status.plan), ("belief", status.believes)):
                if motion is not None:
                    stamps = [stamp + round(i * motion.interval * 1e9) for i in range(len(motion.inputs) + 1)]
                    data = messages.path(stamp, _rolled(motion), stamps)
                    found.append(Shown(f"/robot{status.sender}/{name}", PATH, data))
        return found

    def _markers(self, state: State, *, path: bool) -> list[messages.Lines]:
        current = self._current(state)
        ages: dict[LinkId, float] = {status.link: status.age for status in current}
        drawn = [
            pictures.edges(state.poses, state.distance_errors, state.away),
            pictures.ways_to(state.slots, state.poses),
            pictures.links(state.poses, ages),
            pictures.curves("plans", [_rolled(one.plan) for one in current if one.plan], pictures.BLUE),
            pictures.curves("beliefs", [_rolled(one.believes) for one in current if one.believes], pictures.VIOLET),
        ]
        return [*drawn, pictures.curves("path", [self._path], pictures.GREY)] if path else drawn


def _rolled(motion: Motion) -> FloatArray:
    """The poses (N + 1, 3) of a motion."""
    poses: FloatArray = roll_out(motion.pose[None], motion.inputs[None], motion.interval)[0]
    return poses
