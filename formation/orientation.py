"""The formation's heading at time t: along the path, constant, or turning at a limited rate."""

import math
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from formation.arrays import FloatArray
from formation.clear.opening import PEAK, smooth
from formation.errors import ScenarioError
from formation.formation_spec import Formation
from formation.offsets import Reach
from formation.paths.path import Path, heading
from formation.unicycle import wrap

SHARE = 0.15
"""How fast rotation moves a slot at most where it is limited, as a share of the path's speed: the slots then keep going
forwards, nearly side by side."""
GRID = 0.01
"""Step on which a limited orientation is integrated [s]."""
SMOOTHING = 1.0
"""Length of the moving average that makes a limited orientation's rate continuous [s]."""
STRETCH = 2000
"""Steps that are integrated at a time."""
LONGEST = 20_000.0
"""Of an average [s]: twice the longest episode. It is kept in steps of GRID."""
TURNING = 4.0
"""Where a path turns too tightly, the formation's heading is the mean along so many times its reach: turning back, a
slot then moves within the formation at most at pi / 4 of the path's speed."""
LOOKED_AT = 6000
"""Steps over which the mean speed of such a path is taken."""
SLOWEST = 1e-3
"""A path is taken to be no slower than this [m/s] there."""


class Orientation(Protocol):
    """The formation's heading as a function of time."""

    def angle(self, t: FloatArray) -> FloatArray:
        """Heading (T,) at times t (T,) [rad]."""
        ...


class Along:
    """The heading of the path, as the paper samples it."""

    def __init__(self, path: Path, interval: float) -> None:
        self._path, self._interval = path, interval

    def angle(self, t: FloatArray) -> FloatArray:
        return heading(self._path, t, self._interval)


class Rounded:
    """The heading of the path, but its corners are turned smoothly, so that rotation moves no slot faster than SHARE.

    The path's heading cannot be followed where it jumps, not even by a formation that is stiff: half of the turn is
    made before the corner, half after it.
    """

    def __init__(self, path: Path, interval: float, *, reach: float) -> None:
        """The orientation along a path; arguments as of `Limited`."""
        self._path, self._interval = path, interval
        self._turns = [(at, turn, _time_to_turn(path, at, turn, reach)) for at, turn in path.corners]

    def angle(self, t: FloatArray) -> FloatArray:
        theta = heading(self._path, t, self._interval)
        for at, turn, over in self._turns:
            here = np.abs(t - at) <= over / 2.0
            # The sampled heading jumps within one interval after the corner: take that before it, and the smooth turn.
            passed = t >= at + self._interval
            sampled: FloatArray = np.where(passed, t, np.minimum(t, at))
            legs = heading(self._path, sampled, self._interval)
            turned = legs - turn * passed + turn * smooth((t - at) / over + 0.5)
            theta = np.asarray(np.where(here, turned, theta))
        return theta


def _time_to_turn(path: Path, at: float, turn: float, reach: float) -> float:
    """Duration of the turn at a corner, so that SHARE is kept on both legs [s]."""
    t: FloatArray = at + np.array([-GRID, 0.0, GRID])
    step = np.diff(path.position(t), axis=0)
    speed = float(np.hypot(step[:, 0], step[:, 1]).min()) / GRID
    return PEAK * abs(turn) * reach / (SHARE * speed)


class Fixed:
    """The same heading, always: every slot moves as the centre does."""

    def __init__(self, angle: float) -> None:
        self._angle = angle

    def angle(self, t: FloatArray) -> FloatArray:
        return np.full(t.shape, self._angle)


class _Mean:
    """The moving average of an orientation that is known on a grid, which makes its rate continuous."""

    def __init__(self, first: float, over: float) -> None:
        self._first, self._over = first, over
        self._theta, self._sum = np.zeros(2), np.zeros(2)

    def angle(self, t: FloatArray) -> FloatArray:
        half = self._over / 2.0
        self._extend(float(t.max(initial=0.0)) + half)
        mean: FloatArray = (self._integral(t + half) - self._integral(t - half)) / self._over
        return mean

    def _integral(self, t: FloatArray) -> FloatArray:
        """Of the orientation from the first sample to t: exact for the straight lines between samples."""
        at = (t - self._first) / GRID
        k = np.clip(at.astype(int), 0, len(self._theta) - 2)
        part = at - k
        slope = np.where(at < 0.0, 0.0, self._theta[k + 1] - self._theta[k])
        whole: FloatArray = self._sum[k] + GRID * part * (self._theta[k] + 0.5 * part * slope)
        return whole

    def _extend(self, end: float) -> None:
        """Have samples up to the time `end`."""
        raise NotImplementedError


class Averaged(_Mean):
    """The heading of the path, averaged twice over some time: how a formation turns that cannot turn as the path does.

    It begins a turn that much ahead, and its rate has no jumps.
    """

    def __init__(self, path: Path, interval: float, *, over: float) -> None:
        """The orientation from t = 0 on.

        Args:
            path: of the formation's centre.
            interval: over which the paper samples the path's heading [s].
            over: length of each average [s].
        """
        super().__init__(-2.0 * over, over)
        self._path, self._interval = path, interval

    def _extend(self, end: float) -> None:
        if len(self._theta) > 2 and self._first + GRID * (len(self._theta) - 2) >= end:
            return
        count = 2 * max(STRETCH, math.ceil((end - self._first) / GRID))
        half = round(self._over / 2.0 / GRID)
        t = self._first + GRID * np.arange(-half, count + half + 1, dtype=float)
        whole = np.concatenate([[0.0], np.cumsum(np.unwrap(heading(self._path, t, self._interval)))])
        self._theta = (whole[2 * half + 1 :] - whole[: -2 * half - 1]) / (2 * half + 1)
        self._sum = np.concatenate([[0.0], np.cumsum(GRID * 0.5 * (self._theta[1:] + self._theta[:-1]))])


class Limited(_Mean):
    """The heading of the path, followed at a limited rate, then averaged over SMOOTHING.

    The average keeps the limit, makes the rate continuous, and begins a turn half of SMOOTHING ahead. Before
    t = 0 it has the heading that the path has two seconds before t = 0.
    """

    def __init__(self, path: Path, interval: float, *, rate: float | None, reach: float) -> None:
        """The orientation from t = 0 on.

        Args:
            path: of the formation's centre.
            interval: over which the paper samples the path's heading [s].
            rate: limit [rad/s]; None for SHARE of the path's speed at the outermost slot.
            reach: distance of the outermost slot from the centre [m].
        """
        super().__init__(-2.0 * SMOOTHING, SMOOTHING)
        self._path, self._interval, self._rate, self._reach = path, interval, rate, reach
        start = float(heading(path, np.array([self._first]), interval)[0])
        self._theta, self._sum = np.array([start]), np.zeros(1)

    def _extend(self, end: float) -> None:
        while self._first + GRID * (len(self._theta) - 2) < end:
            first = len(self._theta)
            t = np.asarray(self._first + GRID * np.arange(first, first + STRETCH), dtype=float)
            wish = heading(self._path, t, self._interval)
            if self._rate is None:
                step = self._path.position(t + GRID) - self._path.position(t)
                limit = SHARE * np.hypot(step[:, 0], step[:, 1]) / self._reach
            else:
                limit = np.full(STRETCH, self._rate * GRID)
            theta, found = float(self._theta[-1]), np.empty(STRETCH)
            for j, (angle, most) in enumerate(zip(wish.tolist(), limit.tolist(), strict=True)):
                theta += min(max(wrap(angle - theta), -most), most)
                found[j] = theta
            steps = np.concatenate([self._theta[-1:], found])
            sums = self._sum[-1] + np.cumsum(GRID * 0.5 * (steps[1:] + steps[:-1]))
            self._theta, self._sum = np.concatenate([self._theta, found]), np.concatenate([self._sum, sums])


class Changing:
    """One orientation, and then another: as the shape changes, and with it how fast the formation can turn."""

    def __init__(self, before: Orientation, after: Orientation, *, at: float, over: float) -> None:
        """Both go on all the time; from `at` on the angle between them fades, over so long [s]."""
        self._before, self._after, self._at, self._over = before, after, at, over

    def angle(self, t: FloatArray) -> FloatArray:
        before = self._before.angle(t)
        if t.max(initial=-math.inf) <= self._at:
            return before
        apart = before - self._after.angle(t)
        apart -= 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
        return np.asarray(before - smooth((t - self._at) / self._over) * apart)


def orientation_of(
    formation: Formation,
    path: Path,
    *,
    interval: float,
    reaches: Sequence[Reach],
    rounded: bool,
    tight: Callable[[float], bool],
) -> Orientation:
    """The orientation that the scenario asks for: at each time that of the shape that the formation has then.

    So a change that is ordered while a run goes on alters nothing before it.

    Args:
        formation: says which.
        path: of the formation's centre.
        interval: as in `Limited`.
        reaches: of its shapes, one after the other.
        rounded: whether the path's corners are turned as robots can.
        tight: whether the path turns on a smaller radius than a reach [m].
    """

    def kind(reach: float) -> tuple[str, float]:
        match formation.orientation:
            case "path" if tight(reach):
                return "averaged", reach
            case "path" if rounded and path.corners:
                return "rounded", reach
            case "limited" if formation.turn_rate is None:
                return "limited", reach
            case name:
                return name, 0.0

    def made(name: str, reach: float) -> Orientation:
        match name:
            case "averaged":
                return Averaged(path, interval, over=_long_enough(path, reach))
            case "rounded":
                return Rounded(path, interval, reach=reach)
            case "limited":
                return Limited(path, interval, rate=formation.turn_rate, reach=reach)
            case "fixed":
                return Fixed(formation.heading)
            case _:
                return Along(path, interval)

    last = kind(reaches[0].reach)
    found = made(*last)
    for at, over, reach in reaches[1:]:
        if kind(reach) != last:
            last = kind(reach)
            found = Changing(found, made(*last), at=at, over=over)
    return found


def _long_enough(path: Path, reach: float) -> float:
    """Time in which the formation turns round and no slot has to go backwards [s]."""
    t: FloatArray = GRID * np.arange(LOOKED_AT + 1, dtype=float)
    way = np.diff(path.position(t), axis=0)
    found = TURNING * reach / max(float(np.hypot(way[:, 0], way[:, 1]).mean()) / GRID, SLOWEST)
    if found > LONGEST:
        raise ScenarioError(
            f"formation: expected robots so near that it can turn round within {LONGEST:g} s at the speed "
            f"of its path; got {found:.3g} s"
        )
    return found
