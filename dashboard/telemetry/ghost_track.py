"""The ghost, another controller simulated beside the run: its poses, its trail, and its errors beside the live ones."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dashboard.telemetry.series import POINTS, Series, Trail
from formation.arrays import FloatArray
from formation.metrics import rms, wrapped
from network.messages import Ghost, State

COLUMNS = ("ghost_distance", "ghost_angle", "ghost_tracking")
"""Largest distance error [mm], largest angle error [deg], tracking error [mm]."""
KEPT = 40
"""Poses kept, so that the ghost is drawn at the same stamp as the live robots."""
FAR_BEHIND = 1.0
"""A ghost that is further behind [s] is not drawn: its poses would be compared with those of another time."""
COMPARED_SECONDS = 20.0
"""Length of the window in which errors are compared [s]."""
COMPARED_ROWS = 10
"""Rows that both must have in that window, at least."""
FAR_BETTER = 1000.0
"""Beyond this factor its digits mean nothing."""
LEAST_MM = 1e-3
"""Errors below a micrometre count as one micrometre."""


class GhostTrack:
    """The messages of the ghost that belong to the present episode and the chosen controller."""

    def __init__(self) -> None:
        self.newest: Ghost | None = None
        self._wanted: tuple[int, str, int] = (-1, "", 0)
        self._begin()

    def _begin(self) -> None:
        self.newest = None
        self._poses: deque[tuple[float, FloatArray]] = deque(maxlen=KEPT)
        self._series = Series(len(COLUMNS), 2 * POINTS)  # to reach as far back as the live ones
        self._trail: Trail | None = None

    def update(self, state: State, ghosts: Sequence[Ghost]) -> None:
        """Add the ghost messages since the last call; drop what no longer fits the state."""
        wanted = (state.episode, state.compare, len(state.poses))
        if wanted != self._wanted:
            self._wanted = wanted
            self._begin()
        for ghost in ghosts:
            if (ghost.episode, ghost.controller, len(ghost.poses)) == wanted:
                self._add(ghost)

    def _add(self, ghost: Ghost) -> None:
        if self.newest is not None and ghost.stamp < self.newest.stamp:
            self._begin()  # its process was restarted
        if self._trail is None:
            self._trail = Trail(ghost.poses, ghost.stamp)
        self.newest = ghost
        self._poses.append((ghost.stamp, ghost.poses))
        self._trail.add(ghost.poses, ghost.stamp)
        values = [
            1e3 * np.abs(ghost.distance_errors).max(),
            np.degrees(np.abs(ghost.angle_errors).max()),
            1e3 * ghost.tracking_error,
        ]
        self._series.add(ghost.stamp, np.array(values))

    def poses(self, stamp: float) -> FloatArray | None:
        """(n, 3) at a stamp [s], or the nearest known; None without a ghost, or if it is far behind."""
        if not self._poses or self._poses[-1][0] < stamp - FAR_BEHIND:
            return None
        after = next((i for i, (at, _) in enumerate(self._poses) if at >= stamp), len(self._poses) - 1)
        at, poses = self._poses[after]
        if after == 0 or at <= stamp:
            return poses
        before_at, before = self._poses[after - 1]
        moved = poses - before
        moved[:, 2] = wrapped(moved[:, 2])
        return before + moved * (stamp - before_at) / max(at - before_at, 1e-9)

    def trail(self, poses: FloatArray) -> FloatArray:
        """(n, TRAIL_POINTS, 2) ending at these poses (n, 3) [m]."""
        assert self._trail is not None
        return self._trail.up_to(poses)

    def at(self, stamps: FloatArray) -> dict[str, FloatArray]:
        """COLUMNS by name at these stamps (T,) [s]; NaN where there is no ghost."""
        rows = self._series.rows
        if not len(rows):
            return {name: np.full_like(stamps, np.nan) for name in COLUMNS}
        return {
            name: np.interp(stamps, rows[:, 0], rows[:, 1 + i], left=np.nan, right=np.nan)
            for i, name in enumerate(COLUMNS)
        }


@dataclass(frozen=True, slots=True)
class Comparison:
    """RMS of one error over the last seconds, of the run and of the ghost [mm]."""

    name: str
    live: float
    ghost: float

    @property
    def factor(self) -> str:
        """The run against the ghost in words: "12 x better"."""
        live, ghost = max(self.live, LEAST_MM), max(self.ghost, LEAST_MM)
        ratio = max(live, ghost) / min(live, ghost)
        if ratio < 1.05:
            return "the same"
        word = "better" if live < ghost else "worse"
        if ratio > FAR_BETTER:
            return f"> {FAR_BETTER:.0f} x {word}"
        return f"{ratio:.1f} x {word}" if ratio < 9.95 else f"{float(f'{ratio:.2g}'):.0f} x {word}"


def comparisons(series: Mapping[str, FloatArray], seconds: float = COMPARED_SECONDS) -> list[Comparison]:
    """The run against the ghost over the last seconds of these columns; empty until both have enough rows in common."""
    t = series["t"]
    both = np.isfinite(series[COLUMNS[0]]) & (t > t[-1] - seconds)
    if both.sum() < COMPARED_ROWS:
        return []
    pairs = (("distance", "distance_max", COLUMNS[0]), ("tracking", "tracking", COLUMNS[2]))
    return [Comparison(name, rms(series[live][both]), rms(series[ghost][both])) for name, live, ghost in pairs]
