"""The ghost as the page knows it: where it is, where it has been, and how its errors compare with the live ones."""

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
"""Poses kept, to draw the ghost at the very stamp at which the live robots are drawn."""
FAR_BEHIND = 1.0
"""A ghost that is further behind [s] is not drawn: it would be compared with where the others are by now."""
VERDICT_SECONDS = 20.0
"""The errors of so long are compared."""
VERDICT_ROWS = 10
FAR_BETTER = 1000.0
"""Beyond this factor its digits say nothing."""
NOTHING_MM = 1e-3
"""Errors below a micrometre are all the same on the ground."""


class GhostTrack:
    """What the ghost has said, as far as it belongs to the flight and the comparison of now."""

    def __init__(self) -> None:
        self.newest: Ghost | None = None
        self._wanted: tuple[int, str, int] = (-1, "", 0)
        self._begin()

    def _begin(self) -> None:
        self.newest = None
        self._poses: deque[tuple[float, FloatArray]] = deque(maxlen=KEPT)
        self._series = Series(len(COLUMNS), 2 * POINTS)  # to reach as far back as the live ones
        self._trail: Trail | None = None

    def follow(self, state: State, said: Sequence[Ghost]) -> None:
        """Take in what the ghost has said since the last call; forget what does not fit the state any more."""
        wanted = (state.episode, state.compare, len(state.poses))
        if wanted != self._wanted:
            self._wanted = wanted
            self._begin()
        for ghost in said:
            if (ghost.episode, ghost.controller, len(ghost.poses)) == wanted:
                self._take(ghost)

    def _take(self, ghost: Ghost) -> None:
        if self.newest is not None and ghost.stamp < self.newest.stamp:
            self._begin()  # its process was started again
        if self._trail is None:
            self._trail = Trail(ghost.poses, ghost.stamp)
        self.newest = ghost
        self._poses.append((ghost.stamp, ghost.poses))
        self._trail.add(ghost.poses, ghost.stamp)
        figures = [
            1e3 * np.abs(ghost.distance_errors).max(),
            np.degrees(np.abs(ghost.angle_errors).max()),
            1e3 * ghost.tracking_error,
        ]
        self._series.add(ghost.stamp, np.array(figures))

    def poses(self, stamp: float) -> FloatArray | None:
        """(n, 3) at a stamp [s], or the nearest that is known; None without a ghost, or if it is far behind."""
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
        """(n, TRAIL_POINTS, 2) up to these poses (n, 3) [m]."""
        assert self._trail is not None
        return self._trail.up_to(poses)

    def at(self, stamps: FloatArray) -> dict[str, FloatArray]:
        """COLUMNS by name at these stamps (T,) [s]; NaN where the ghost has not been."""
        rows = self._series.rows
        if not len(rows):
            return {name: np.full_like(stamps, np.nan) for name in COLUMNS}
        return {
            name: np.interp(stamps, rows[:, 0], rows[:, 1 + i], left=np.nan, right=np.nan)
            for i, name in enumerate(COLUMNS)
        }


@dataclass(frozen=True, slots=True)
class Comparison:
    """One error of both flights, RMS over the last seconds [mm]."""

    name: str
    live: float
    ghost: float

    @property
    def words(self) -> str:
        """How the live flight does beside the ghost: "12 x better"."""
        live, ghost = max(self.live, NOTHING_MM), max(self.ghost, NOTHING_MM)
        factor = max(live, ghost) / min(live, ghost)
        if factor < 1.05:
            return "the same"
        word = "better" if live < ghost else "worse"
        if factor > FAR_BETTER:
            return f"> {FAR_BETTER:.0f} x {word}"
        return f"{factor:.1f} x {word}" if factor < 9.95 else f"{float(f'{factor:.2g}'):.0f} x {word}"


def verdicts(series: Mapping[str, FloatArray]) -> list[Comparison]:
    """How the two flights compare, from the columns of the history; nothing before both have some rows in common."""
    t = series["t"]
    both = np.isfinite(series[COLUMNS[0]]) & (t > t[-1] - VERDICT_SECONDS)
    if both.sum() < VERDICT_ROWS:
        return []
    pairs = (("distance", "distance_max", COLUMNS[0]), ("tracking", "tracking", COLUMNS[2]))
    return [Comparison(name, rms(series[live][both]), rms(series[ghost][both])) for name, live, ghost in pairs]
