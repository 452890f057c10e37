"""What was, for trails and plots: simulated time only, started anew with every flight."""

import numpy as np

from dashboard.links import LinkView
from formation.arrays import FloatArray
from network.messages import State

TRAIL_POINTS = 60
TRAIL_SECONDS = 0.2
"""Between two points of a trail: 12 s in all."""
SERIES_POINTS = 450
SERIES_SECONDS = 0.1
"""Between two points of a plot: 45 s in all. More points than pixels would only cost."""
COLUMNS = ("t", "distance_max", "distance_mean", "angle", "tracking", "age_max", "age_mean", "event")


class History:
    """Trails of all robots and the series behind the plots."""

    def __init__(self) -> None:
        self.epoch = -1
        self._trails: FloatArray = np.empty((0, TRAIL_POINTS, 2))
        self._trail_at = 0.0
        self._rows: FloatArray = np.empty((0, len(COLUMNS)))
        self._row_at = -np.inf
        self._events = 0
        self._marks: list[float] = []

    def add(self, state: State, links: list[LinkView]) -> None:
        """Take the newest state in."""
        if state.epoch != self.epoch or state.poses.shape[0] != self._trails.shape[0]:
            self._begin(state)
        if state.stamp >= self._trail_at + TRAIL_SECONDS:
            self._trail_at = state.stamp
            self._trails = np.concatenate([self._trails[:, 1:], state.poses[:, None, :2]], axis=1)
        for event in state.events:
            if event.number > self._events and event.kind != "run" and event.stamp > 0.0:
                self._marks.append(event.stamp)
        self._events = max([self._events, *(event.number for event in state.events)])
        self._add_row(state, links)

    def _begin(self, state: State) -> None:
        self.epoch = state.epoch
        self._trails = np.repeat(state.poses[:, None, :2], TRAIL_POINTS, axis=1)
        self._trail_at = state.stamp
        self._rows, self._row_at = np.empty((0, len(COLUMNS))), -np.inf
        self._marks = []
        self._events = max((event.number for event in state.events), default=0)

    def _add_row(self, state: State, links: list[LinkView]) -> None:
        ages = [link.age for link in links if link.age is not None] or [0.0]
        distance = 1e3 * np.abs(state.distance_errors)
        row = np.array(
            [
                state.stamp,
                distance.max(),
                distance.mean(),
                np.degrees(np.abs(state.angle_errors).max()),
                1e3 * state.tracking_error,
                1e3 * max(ages),
                1e3 * sum(ages) / len(ages),
                0.0,
            ]
        )
        if state.stamp < self._row_at + SERIES_SECONDS and len(self._rows):
            self._rows[-1, 1:] = np.maximum(self._rows[-1, 1:], row[1:])  # peaks survive the thinning
            return
        self._row_at = state.stamp
        while self._marks and self._marks[0] <= state.stamp:
            row[-1] = 1.0
            self._marks.pop(0)
        self._rows = np.concatenate([self._rows[1 - SERIES_POINTS :], row[None]])

    def trails(self, poses: FloatArray) -> FloatArray:
        """(n, TRAIL_POINTS, 2), oldest first, up to where the robots are drawn now [m]."""
        if len(self._trails) != len(poses):
            return np.repeat(poses[:, None, :2], TRAIL_POINTS, axis=1)
        trails = self._trails.copy()
        trails[:, -1] = poses[:, :2]
        return trails

    def series(self) -> dict[str, FloatArray]:
        """Columns by name, at least two points each; errors in mm and degrees, ages in ms."""
        rows = self._rows if len(self._rows) > 1 else np.zeros((2, len(COLUMNS)))
        if len(self._rows) <= 1:
            rows[1, 0] = 1.0
        return {name: np.ascontiguousarray(rows[:, i]) for i, name in enumerate(COLUMNS)}
