"""When the formation is where: the clock against the path's own time, which waits where robots cannot keep up.

The path's time is cut into steps as long as a tick. A step takes as long as the slot that is hardest to follow needs
for it: longer than the tick where a slot is faster, or turns faster, than its robot can. Then the reference is late
for all robots alike; how late is the `lag`. A path that every slot can follow is never late, and its time is the
clock, to the last bit.
"""

import numpy as np

from formation.arrays import FloatArray
from formation.metrics import wrapped
from formation.slot_motion import Motion

MARGIN = 0.95
"""Share of the limits that a slowed reference uses; the rest is left to the controllers."""
STRETCH = 2000
"""Steps that are computed at a time."""
COARSE = 20
"""Of a smooth path, one step in so many is looked at first ..."""
EASY = 0.5
"""... and if those use no more than this share of the limits, the others can be followed too."""


class Schedule:
    """The path's time as a function of the clock."""

    def __init__(self, motion: Motion, limits: FloatArray, step: float) -> None:
        """A schedule from t = 0 on.

        Args:
            motion: of all slots.
            limits: (2,) of v and omega [m/s, rad/s].
            step: of the path's time [s].
        """
        self._motion, self._limits, self.step = motion, limits, step
        self._lags, self._needs = np.zeros(1), np.zeros(0)

    def path_time(self, t: FloatArray) -> FloatArray:
        """The path's time at clock times t, of the shape of t [s]."""
        self._extend(float(t.max(initial=0.0)))
        if self._lags[-1] == 0.0:
            return t
        clock = self.step * np.arange(len(self._lags)) + self._lags
        i = np.clip(np.searchsorted(clock, t, side="right") - 1, 0, len(self._needs) - 1)
        late: FloatArray = self.step * (i + (t - clock[i]) / self._needs[i])
        return np.where((self._needs[i] > self.step) & (t > 0.0), late, t - self._lags[i] * (t > 0.0))

    def lag(self, t: float) -> float:
        """How late the reference is at clock time t [s]."""
        return t - float(self.path_time(np.array([t]))[0])

    def slow(self, path_time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Steps (T,) of the path's time, and whether each takes longer than by the clock (T,)."""
        i = np.clip(np.floor(path_time / self.step).astype(int), 0, len(self._needs) - 1)
        begin: FloatArray = i * self.step
        return begin, (self._needs[i] > self.step) & (path_time > 0.0)

    def _extend(self, end: float) -> None:
        while len(self._needs) * self.step + self._lags[-1] <= end + self.step:
            first = len(self._needs)
            needs = np.maximum(self.needs(first, STRETCH).max(axis=(1, 2)), self.step)
            more = self._lags[-1] + np.cumsum(needs - self.step)
            self._needs, self._lags = np.concatenate([self._needs, needs]), np.concatenate([self._lags, more])

    def needs(self, first: int, count: int) -> FloatArray:
        """How long the steps from number `first` on take at least: (count, n, 2), for v and for omega [s]."""
        motion, step = self._motion, self.step
        if self._smooth(first * step, (first + count) * step):
            looked: FloatArray = step * np.arange(first, first + count, COARSE, dtype=float)
            both = motion.poses(np.concatenate([looked, looked + step]))
            easy = self._needed(both[: len(looked)], both[len(looked) :])
            if easy.max() <= EASY * step:
                return np.repeat(easy, COARSE, axis=0)[:count]
        nodes: FloatArray = step * np.arange(first, first + count + 1, dtype=float)
        poses = motion.poses(nodes)
        needed = self._needed(poses[:-1], poses[1:])
        for at, _ in motion.path.corners:  # a corner of the path is turned as well as the robots can
            needed[(nodes[1:] >= at) & (nodes[:-1] <= at + motion.interval), :, 1] = 0.0
        return needed

    def _needed(self, now: FloatArray, later: FloatArray) -> FloatArray:
        moved = later - now
        way, turn = np.hypot(moved[..., 0], moved[..., 1]), np.abs(wrapped(moved[..., 2]))
        return np.stack([way, turn], axis=-1) / (MARGIN * self._limits)

    def _smooth(self, begin: float, end: float) -> bool:
        corners = any(begin <= at + self._motion.interval and at <= end for at, _ in self._motion.path.corners)
        return self._motion.path.smooth and not corners and not self._motion.offsets.moving(begin, end)
