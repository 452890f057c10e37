"""What each robot's controller believes of the neighbour upstream, against where that robot is."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from dashboard.telemetry.snapshot import Snapshot
from formation.arrays import FloatArray
from formation.pattern import upstream
from formation.unicycle import roll_out, step
from network.messages import State, Status
from network.values import Motion


class BeliefView(NamedTuple):
    """The belief of one robot."""

    receiver: int
    sender: int
    """The robot that it believes something of."""
    pose: FloatArray
    """(3,) where it believes the sender to be now [m, m, rad]."""
    line: FloatArray
    """(N + 1, 2) where it believes the sender to drive from now on [m]."""
    offset: FloatArray
    """(2,) from where the sender is to there [m]."""

    @property
    def error(self) -> float:
        """Distance of the two [m]."""
        return math.hypot(*self.offset.tolist())


class Beliefs:
    """The newest beliefs: each is compared with the truth once, when it comes in.

    Statuses come ten times a second; carried on in between by inputs that are not the sender's, a belief would seem
    worse than it is. The page shows it beside the sender, as far off as it was.
    """

    def __init__(self) -> None:
        self._known: dict[int, tuple[Motion | None, BeliefView | None]] = {}

    def update(self, snapshot: Snapshot) -> list[BeliefView]:
        """The beliefs of all robots, in the order of the receivers."""
        state, scenario = snapshot.state, snapshot.scenario
        if state is None or scenario is None:
            return []
        known = self._known
        new = {i: one for i, one in snapshot.statuses.items() if i not in known or known[i][0] is not one.believes}
        interval = scenario.controller.prediction_interval
        found = {view.receiver: view for view in beliefs(state, new, snapshot.poses, snapshot.stamp, interval)}
        self._known = {
            i: (one.believes, found.get(i)) if i in new else known[i] for i, one in sorted(snapshot.statuses.items())
        }
        return [view for _, view in self._known.values() if view is not None and view.sender <= len(snapshot.poses)]


def beliefs(
    state: State, statuses: Mapping[int, Status], poses: FloatArray, stamp: float, interval: float
) -> list[BeliefView]:
    """The beliefs of all robots that have planned in this episode, in the order of the receivers.

    Args:
        state: the newest.
        statuses: of the agents.
        poses: (n, 3) true poses at `stamp` [m, m, rad].
        stamp: now [s].
        interval: for which each input of a plan is held [s].
    """
    n, found = len(poses), list[tuple[int, FloatArray, FloatArray]]()
    for receiver, status in sorted(statuses.items()):
        held = status.believes
        plays = 1 <= receiver <= n and receiver not in state.away
        if held is not None and status.episode == state.episode and plays:
            found.append((receiver, *_at(held.pose, held.inputs, stamp - held.begins, interval)))
    steps = {len(left) for _, _, left in found}
    if len(steps) != 1:  # none, or of agents that differ in their horizon: they are no agents of this scenario
        return []
    lines = roll_out(np.array([pose for _, pose, _ in found]), np.array([left for _, _, left in found]), interval)
    views = []
    for (receiver, pose, _), line in zip(found, lines, strict=True):
        sender = upstream(receiver, n, state.away)
        views.append(BeliefView(receiver, sender, pose, line[:, :2], pose[:2] - poses[sender - 1, :2]))
    return views


def _at(pose: FloatArray, inputs: FloatArray, elapsed: float, interval: float) -> tuple[FloatArray, FloatArray]:
    """Pose and inputs of a plan `elapsed` seconds after it begins; past its end its last input holds on."""
    x, y, theta = pose.tolist()
    rows, left, gone = inputs.tolist(), elapsed, 0
    while gone < len(rows) - 1 and left > interval:
        v, omega = rows[gone]
        x, y, theta = step(x, y, theta, v, omega, interval)
        left -= interval
        gone += 1
    v, omega = rows[gone]
    x, y, theta = step(x, y, theta, v, omega, left)
    rest = np.concatenate([inputs[gone:], np.repeat(inputs[-1:], gone, axis=0)])
    return np.array([x, y, theta]), rest
