"""The local origin of a scenario: what is drawn or kept has single precision, which is 6 cm at 700 km.

Everything that the page draws, keeps and measures is relative to it; what is written for a reader, or asked of the
world, is in the scenario's coordinates again.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dashboard.telemetry.snapshot import Snapshot
from formation.arrays import FloatArray, frozen
from formation.scenario.scenario import Scenario
from network.messages import Ghost, State, Status
from network.values import Motion

NEAR = 100.0
"""Paths that begin nearer than this are drawn in their own coordinates [m]."""
STEP = 10.0
"""An origin is a multiple of this [m]."""
HERE: FloatArray = frozen(np.zeros(2))


def origin_of(scenario: Scenario) -> FloatArray:
    """(2,) the local origin in the scenario's coordinates [m]; zeros where none is needed."""
    start = np.asarray(scenario.path.position(np.array(0.0)))
    return HERE if np.abs(start).max() < NEAR else np.asarray(STEP * np.round(start / STEP))


class Localiser:
    """Moves what is known of a run to the origin of its scenario."""

    def __init__(self) -> None:
        self._scenario: Scenario | None = None
        self._origin = HERE
        self._state: tuple[State, State] | None = None
        self._statuses: dict[int, tuple[Status, Status]] = {}

    def local(self, snapshot: Snapshot) -> Snapshot:
        """The snapshot relative to the origin; itself, if that is zero."""
        if snapshot.scenario is not self._scenario and snapshot.scenario is not None:
            self._scenario, self._origin = snapshot.scenario, origin_of(snapshot.scenario)
        if not self._origin.any() or snapshot.state is None:
            return snapshot
        if self._state is None or self._state[0] is not snapshot.state:
            self._state = snapshot.state, _state(snapshot.state, self._origin)
        return replace(
            snapshot,
            state=self._state[1],
            statuses=self._moved(snapshot.statuses),
            poses=_poses(snapshot.poses, self._origin),
            ghosts=tuple(_ghost(ghost, self._origin) for ghost in snapshot.ghosts),
            origin=self._origin,
        )

    def _moved(self, statuses: Mapping[int, Status]) -> dict[int, Status]:
        """The statuses, each of which is moved once."""
        known = self._statuses
        self._statuses = {
            robot: known[robot]
            if robot in known and known[robot][0] is status
            else (status, _status(status, self._origin))
            for robot, status in statuses.items()
        }
        return {robot: moved for robot, (_, moved) in self._statuses.items()}


def _poses(poses: FloatArray, origin: FloatArray) -> FloatArray:
    """Poses (..., 3) relative to the origin [m, m, rad]."""
    return np.asarray(poses - np.append(origin, 0.0))


def _state(state: State, origin: FloatArray) -> State:
    poses, slots, centre = (_poses(value, origin) for value in (state.poses, state.slots, state.centre))
    goal = state.driving.goal
    near = None if goal is None else (goal[0] - float(origin[0]), goal[1] - float(origin[1]))
    return replace(state, poses=poses, slots=slots, centre=centre, driving=replace(state.driving, goal=near))


def _status(status: Status, origin: FloatArray) -> Status:
    way = status.way.copy()
    way[:, 2:4] -= origin
    return replace(status, plan=_motion(status.plan, origin), believes=_motion(status.believes, origin), way=way)


def _motion(motion: Motion | None, origin: FloatArray) -> Motion | None:
    return motion and replace(motion, pose=_poses(motion.pose, origin))


def _ghost(ghost: Ghost, origin: FloatArray) -> Ghost:
    return replace(ghost, poses=_poses(ghost.poses, origin))
