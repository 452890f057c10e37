"""The last 45 s for trails and plots, in simulated time; cleared at the start of every episode."""

from collections.abc import Mapping, Sequence

import numpy as np

from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.ghost_track import GhostTrack
from dashboard.telemetry.links import LinkView
from dashboard.telemetry.series import Series, Trail
from formation.arrays import FloatArray
from network.messages import State, Status

COLUMNS = (
    "t",
    "distance_max",
    "distance_mean",
    "angle",
    "tracking",
    "age_max",
    "age_mean",
    "solve_max",
    "solve_mean",
    "off_max",
    "off_mean",
    "event",
)


class History:
    """Trails of all robots, the series behind the plots, and the ghost."""

    def __init__(self) -> None:
        self.episode = -1
        self.ghost = GhostTrack()
        self._trail = Trail(np.empty((0, 3)), 0.0)
        self._series = Series(len(COLUMNS) - 1)
        self._robots = 0
        self._events = 0
        self._marks: list[float] = []

    def add(
        self,
        state: State,
        links: list[LinkView],
        statuses: Mapping[int, Status],
        beliefs: Sequence[BeliefView] = (),
    ) -> None:
        """Add the newest state, with the links' ages, the solve times in the statuses, and the beliefs' errors."""
        if state.episode != self.episode or len(state.poses) != self._robots:
            self._begin(state)
        self._trail.add(state.poses, state.stamp)
        for event in state.events:
            if event.number > self._events and event.kind != "run" and event.stamp > 0.0:
                self._marks.append(event.stamp)
        self._events = max([self._events, *(event.number for event in state.events)])
        self._series.add(state.stamp, self._row(state, links, statuses, beliefs))

    def _begin(self, state: State) -> None:
        self.episode, self._robots = state.episode, len(state.poses)
        self._trail = Trail(state.poses, state.stamp)
        self._series = Series(len(COLUMNS) - 1)
        self._marks = []
        self._events = max((event.number for event in state.events), default=0)

    def _row(
        self,
        state: State,
        links: list[LinkView],
        statuses: Mapping[int, Status],
        beliefs: Sequence[BeliefView],
    ) -> FloatArray:
        """One row of COLUMNS, without its stamp."""
        ages = [link.age for link in links if link.age is not None] or [0.0]
        solves = [status.solve for status in statuses.values() if status.episode == state.episode]
        offs = [1e3 * belief.error for belief in beliefs]
        distance = 1e3 * np.abs(np.delete(state.distance_errors, [robot - 1 for robot in state.away]))
        passed = [at for at in self._marks if at <= state.stamp]
        self._marks = [at for at in self._marks if at > state.stamp]
        return np.array(
            [
                distance.max(),
                distance.mean(),
                np.degrees(np.abs(state.angle_errors).max()),
                1e3 * state.tracking_error,
                1e3 * max(ages),
                1e3 * sum(ages) / len(ages),
                1e3 * max(solves, default=0.0),
                1e3 * sum(solves) / max(1, len(solves)),
                max(offs, default=0.0),
                sum(offs) / max(1, len(offs)),
                float(bool(passed)),
            ]
        )

    def trails(self, poses: FloatArray) -> FloatArray:
        """(n, TRAIL_POINTS, 2), oldest first, ending at the poses that are drawn now [m]."""
        return self._trail.up_to(poses)

    def series(self) -> dict[str, FloatArray]:
        """Columns by name, at least two points each; errors in mm and degrees, ages and solve times in ms.

        The ghost's columns (dashboard/telemetry/ghost_track.py) are among them, NaN where there is no ghost.
        """
        rows = self._series.rows
        if len(rows) < 2:
            rows = np.zeros((2, len(COLUMNS)))
            rows[1, 0] = 1.0
        found = {name: np.ascontiguousarray(rows[:, i]) for i, name in enumerate(COLUMNS)}
        return {**found, **self.ghost.at(found["t"])}
