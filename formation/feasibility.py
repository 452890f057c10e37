"""Whether robots can follow what a scenario asks of them, slot by slot, and where not: one report for all who ask."""

from typing import NamedTuple

import numpy as np

from formation.paths.turns import Turn, place_at
from formation.paths.waypoints import Waypoints
from formation.schedule import MARGIN, STRETCH, Schedule
from formation.slot_motion import Motion

SHOWN = 3
"""Tight turns that are told one by one."""
DEGREES = (90.0, 180.0)
"""Bounds of latitudes and longitudes."""
ALLOWED = MARGIN * (1.0 + 1e-9)
"""Share of a limit that may be asked for without a word."""
NEARLY = 0.999
"""What asks for so much of the most is alike."""
TINY = 100.0
"""Coordinates that are so many times larger than what they span may be degrees."""


class Demand(NamedTuple):
    """The most that one slot asks of its robot."""

    robot: int
    speed: float
    """[m/s]."""
    speed_at: str
    """Where, for the user."""
    turn_rate: float
    """[rad/s]."""
    turn_rate_at: str
    """Where, for the user."""


class Feasibility(NamedTuple):
    """What the slots ask for, against the limits."""

    demands: tuple[Demand, ...]
    """By robot."""
    limits: tuple[float, float]
    """Of v and omega [m/s, rad/s]."""
    turns: tuple[Turn, ...]
    """Where the path turns on a smaller radius than the formation's reach."""
    reach: float
    """Of the formation [m]."""
    lag: float
    """How late the reference is at the end because it slows down [s]."""
    together: bool
    """Whether every slot is too fast at the same time."""
    hint: str
    """What the user may want to do."""
    stops: bool = False
    """Whether the limit of v is what robots can stop from behind each other."""

    @property
    def line(self) -> str:
        """One line that says what robots cannot follow, and where; empty if there is nothing."""
        parts = [part for part in (self._turns(), self._speed(), self._rate()) if part]
        if not parts:
            return ""
        late = [f"the reference slows down for all and is {self.lag:.3g} s late at the end"] if self.lag > 0.0 else []
        return "; ".join([*parts, *late, *([self.hint] if self.hint else [])])

    def _turns(self) -> str:
        if not self.turns:
            return ""
        first = sorted(self.turns, key=lambda turn: turn.radius)[:SHOWN]
        more = f" (and {len(self.turns) - SHOWN} more like it)" if len(self.turns) > SHOWN else ""
        return (
            f"{', '.join(turn.place for turn in sorted(first))}{more}: on a radius of {first[0].radius:.2g} m, and the "
            f"formation reaches {self.reach:.2g} m, so it turns more slowly than the path"
        )

    def _speed(self) -> str:
        worst, limit = max(self.demands, key=lambda demand: demand.speed), self.limits[0]
        if worst.speed <= ALLOWED * limit:
            return ""
        least = min(self.demands, key=lambda demand: demand.speed)
        who, demand = ("the path", least) if self.together else (f"the slot of robot {worst.robot}", worst)
        why = ", with robots.avoid, to stop in time behind each other" if self.stops else ""
        return f"{who} asks for {demand.speed:.3g} m/s; the limit is {limit:.3g}{why} ({demand.speed_at})"

    def _rate(self) -> str:
        worst, limit = max(self.demands, key=lambda demand: demand.turn_rate), self.limits[1]
        if worst.turn_rate <= ALLOWED * limit:
            return ""
        return (
            f"the slot of robot {worst.robot} asks for {worst.turn_rate:.3g} rad/s; the limit is {limit:.3g} "
            f"({worst.turn_rate_at})"
        )


def examine(
    motion: Motion, schedule: Schedule, limits: tuple[float, float], turns: list[Turn], *, until: float, duration: float
) -> Feasibility:
    """The report on a scenario.

    Args:
        motion: of all slots.
        schedule: of their reference.
        limits: of v and omega [m/s, rad/s].
        turns: that are too tight.
        until: by the path's time, how far it is looked at [s].
        duration: of the episode [s].
    """
    step, count = schedule.step, max(1, round(until / schedule.step))
    most, at = np.zeros((motion.offsets.size, 2)), np.zeros((motion.offsets.size, 2))
    path, together = motion.path, False
    for first in range(0, count, STRETCH):
        needs = schedule.needs(first, min(STRETCH, count - first))
        together |= bool((needs[:, :, 0].min(axis=1) > ALLOWED / MARGIN * step).any())
        here = needs.max(axis=0)
        when = first + (needs >= NEARLY * here).argmax(axis=0)  # the first of several that are alike
        at = np.where(NEARLY * here > most, when, at)
        most = np.maximum(most, here)
    asked = most / step * MARGIN * np.array(limits)
    return Feasibility(
        tuple(
            Demand(robot, float(v), place_at(path, float(k[0])), float(omega), place_at(path, float(k[1])))
            for robot, ((v, omega), k) in enumerate(zip(asked, at * step, strict=True), start=1)
        ),
        limits,
        tuple(turns),
        motion.offsets.reach,
        schedule.lag(duration),
        together,
        _hint(motion, bool(turns) or bool((asked[:, 1] > ALLOWED * limits[1]).any())),
    )


def unexamined(robots: int, limits: tuple[float, float], reach: float) -> Feasibility:
    """The report on a path that is not known before it is driven, within the limits.

    Args:
        robots: how many there are.
        limits: of v and omega [m/s, rad/s].
        reach: of the formation [m].
    """
    demands = tuple(Demand(robot, 0.0, "", 0.0, "") for robot in range(1, robots + 1))
    return Feasibility(demands, limits, (), reach, 0.0, together=False, hint="")


def _hint(motion: Motion, sharp: bool) -> str:
    path = motion.path
    if not isinstance(path, Waypoints):
        return ""
    points = np.abs(path.course.points)
    span = np.ptp(path.course.points, axis=0).max()
    degrees = points.max(axis=0).min() <= DEGREES[0] and points.max() <= DEGREES[1]
    if degrees and points.min() > TINY * span:
        return "these points look like degrees of latitude and longitude: expected metres"
    return "path.smoothing = 0.05 (m) would round it" if sharp and path.smoothing == 0.0 else ""
