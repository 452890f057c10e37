"""Sensors of the bodies: localisation that is late, noisy, sometimes far off or absent, and relative sensing."""

from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray, read_only
from formation.bodies.nominal import Nominal
from formation.disturbances import Disturbance
from formation.pattern import upstream
from formation.scenario.scenario import Scenario
from network.values import NO_PLACES, maker
from world.bodies.draws import CHANCE, LOCALISATION, OUTLIER, RELATIVE, Draws

OUTLIER_HEADING = 0.25
"""Standard deviation that an outlier adds to the heading [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What sensors deliver at one tick."""

    tick: int
    """The tick that was measured; earlier than the one at which it arrives if localisation takes time."""
    poses: FloatArray
    """(n, 3) localised; rows of robots that are not in `localised` are zero [m, m, rad]."""
    localised: list[int]
    """Numbers of the robots whose localisation delivered."""
    relatives: FloatArray
    """(n or 0, 2) position of the upstream neighbour in the own frame [m]; no rows without relative sensing."""


_make_measured = maker(Measured)


class Sensors:
    """The sensors of all robots. What they add depends on seed, robot and tick alone."""

    def __init__(self, scenario: Scenario, nominal: Nominal) -> None:
        self._nominal = nominal
        self._dropouts = scenario.bodies.localisation.dropouts
        self.disturbances: Sequence[Disturbance] = scenario.disturbances
        """Of which some blind a robot."""
        self._share, self._size = scenario.bodies.localisation.outliers, scenario.bodies.localisation.outlier_size
        self._dt = scenario.control_interval
        n = scenario.size
        self._spread = np.array([nominal.position, nominal.position, nominal.heading])
        self._noise = Draws(scenario.seed, LOCALISATION, n, 3)
        self._chance = Draws(scenario.seed, CHANCE, n, 1, uniform=True)
        self._outliers = Draws(scenario.seed, OUTLIER, n, 3)
        self._relative = Draws(scenario.seed, RELATIVE, n, 2)
        self._noisy = bool(self._spread.any()) or self._share > 0.0
        self._everybody = list(range(1, n + 1))
        self._past: deque[FloatArray] = deque(maxlen=nominal.age + 1)
        self._upstream: list[int] | None = None
        """Row of the robot that each one sees, where the ring is closed over some."""

    def close_over(self, away: Collection[int]) -> None:
        """From now on robots see those upstream in the ring of those who are not away."""
        n = len(self._everybody)
        self._upstream = [upstream(robot, n, away) - 1 for robot in self._everybody] if away else None

    def measure(self, tick: int, poses: FloatArray) -> Measured | None:
        """What arrives at this tick, at which the robots are at poses (n, 3); call once a tick, in order."""
        self._past.append(poses)
        measured = tick - self._nominal.age
        if measured < 0 or measured % self._nominal.period:
            return None
        return self._seen(measured, self._past[0])

    def _seen(self, tick: int, poses: FloatArray) -> Measured:
        robots = self._everybody
        seen = poses
        if self._noisy:
            seen = seen + self._spread * self._noise.at(tick)
        if self._share > 0.0:
            wild = np.array([self._size, self._size, OUTLIER_HEADING]) * self._outliers.at(tick)
            seen = seen + np.where(self._chance.at(tick) < self._share, wild, 0.0)
        blind = self._blind(tick) if self._dropouts or self.disturbances else None
        if blind:
            robots = [robot for robot in robots if robot not in blind]
            seen = np.array(seen)
            seen[[robot - 1 for robot in blind if robot <= len(poses)]] = 0.0
        sigma = self._nominal.relative
        relatives = NO_PLACES if sigma is None else read_only(self._related(poses) + sigma * self._relative.at(tick))
        return _make_measured(tick, seen if seen is poses else read_only(seen), robots, relatives)

    def _related(self, poses: FloatArray) -> FloatArray:
        """(n, 2): where each robot's upstream neighbour is, in its own frame [m]."""
        places, found = poses[:, :2], np.empty((len(poses), 2))
        if self._upstream is None:
            found[1:] = places[:-1] - places[1:]
            found[0] = places[-1] - places[0]
        else:
            found[:] = places[self._upstream] - places
        c, s, x, y = np.cos(poses[:, 2]), np.sin(poses[:, 2]), found[:, 0].copy(), found[:, 1].copy()
        found[:, 0] = c * x + s * y
        found[:, 1] = c * y - s * x
        return found

    def _blind(self, tick: int) -> set[int]:
        """Numbers of the robots that localisation does not see at a tick."""
        now = tick * self._dt
        dropped = {entry.robot for entry in self._dropouts if entry.at <= now + 1e-9 < entry.until}
        return dropped | {entry.robot for entry in self.disturbances if entry.blind and entry.on(now)}
