"""The ledger: every excursion of a robot's error above its limit, and what is likely to have caused it.

A robot's error is how far it is from where it should be as its upstream neighbour sees it: the difference of both
robots' places less that of both slots. docs/theory.md, section 9, has the rule that names a cause.
"""

from collections import deque
from collections.abc import Mapping, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.disturbances import Disturbance
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.pattern import downstream, upstream
from formation.scenario.scenario import Scenario
from network.messages import Command
from network.values import Excursion

QUIET_SECONDS = 0.5
"""An excursion is over once the error has been below the limit for so long [s]: else one is many."""
HOPS = 2
"""What acts on a robot may cause an excursion so many robots downstream; farther, once it has shown nearer."""
KEPT, REMEMBERED = 1000, 120.0
"""Excursions that are kept of an episode, and how long a cause that is over can be one [s]."""
FEW = 16
"""Errors of so few robots are looked at one by one."""
NONE_FOUND = "none found"


@dataclass(slots=True)
class _Cause:
    """A fault or a push."""

    key: object
    """What it is, as long as it acts."""
    robot: int
    """On which it acts; 0 for all."""
    text: str
    begins: float
    """[s]."""
    ends: float | None = None
    """[s]; None while it acts."""

    @property
    def of_link(self) -> bool:
        """Whether it is a fault of a link."""
        return isinstance(self.key, tuple) and isinstance(self.key[0], LinkId)


class Ledger:
    """The excursions of one episode."""

    def __init__(self, scenario: Scenario) -> None:
        """None so far."""
        self.limit = scenario.metrics.limit(scenario.nominal.position, scenario.spacing)
        """[m]."""
        self.count = 0
        """Excursions so far, with those that go on."""
        self._n = scenario.size
        self._before = np.arange(self._n) - 1
        """Row of the robot upstream."""
        self._square_limit = self.limit * self.limit
        self._horizon = scenario.controller.horizon * scenario.controller.prediction_interval
        self._open: dict[int, Excursion] = {}
        self._below: dict[int, float] = {}
        """Of an excursion that goes on: since when the error has been below the limit."""
        self._closed: deque[Excursion] = deque(maxlen=KEPT)
        self._causes: list[_Cause] = []
        self._never_within = set(range(1, self._n + 1))
        """Who has not been within the limit yet: the way to the slots at the start is no excursion."""
        self._acted: Mapping[int, Command] = {}
        """The newest command of each robot, with the age of the plan that it acts on."""
        self._told = scenario.path.known_to == "leader"
        """Whether who is cut off from the others does not know the way."""
        self._away: Set[int] = frozenset()
        self._playing: Set[int] = frozenset(range(1, self._n + 1))
        """Robots that are away, and those that have an agent and are in the ring."""
        self._since = np.zeros(self._n)
        """Since when each of the latter has been so [s]."""
        self._seen: tuple[object, ...] = ()

    def look(
        self,
        now: float,
        poses: FloatArray,
        slots: FloatArray,
        *,
        commands: Mapping[int, Command],
        faults: Mapping[LinkId, Fault],
        disturbances: tuple[Disturbance, ...],
        live: Set[int],
        away: frozenset[int] = frozenset(),
    ) -> list[str]:
        """A tick: what is, and what acts, at `now` [s].

        Args:
            now: simulated time [s].
            poses: (n, 3) true poses.
            slots: (n, 3).
            commands: of the tick that led here.
            faults: every link that is not perfect.
            disturbances: that act.
            live: robots that have an agent.
            away: robots over which the ring is closed: they have no error, and nobody's depends on them.

        Returns:
            A line for each excursion that begins or is over.
        """
        self._acted = commands if len(commands) == self._n else {**self._acted, **commands}
        if self._seen != (faults, disturbances, live, away):
            self._seen = (faults, disturbances, frozenset(live), away)
            self._note_causes(now, faults, disturbances, live)
            self._note_ring(now, away, live - away)
        if self._n <= FEW and not away and not self._open and self._all_within(poses, slots):
            self._never_within.clear()
            return []
        off = poses[:, :2] - slots[:, :2]
        for robot in away:
            off[robot - 1] = off[upstream(robot, self._n, away) - 1]
        gap = off - off.take(self._before, axis=0)
        square = (gap * gap).sum(axis=1)
        if square.max() <= self._square_limit:
            self._never_within.clear()
            if not self._open:
                return []
        errors = np.sqrt(square)
        if self._never_within:
            self._never_within &= set((np.flatnonzero(square > self._square_limit) + 1).tolist())
            errors[[robot - 1 for robot in self._never_within]] = 0.0
        return self._update(now, errors.tolist())

    def _all_within(self, poses: FloatArray, slots: FloatArray) -> bool:
        """Whether no error is above the limit, by Python's arithmetic: of few robots faster, and the same bits."""
        places, wanted, limit = poses.tolist(), slots.tolist(), self._square_limit
        before_x, before_y = places[-1][0] - wanted[-1][0], places[-1][1] - wanted[-1][1]
        for (x, y, _), (u, v, _) in zip(places, wanted, strict=True):
            off_x, off_y = x - u, y - v
            gap_x, gap_y = off_x - before_x, off_y - before_y
            if not gap_x * gap_x + gap_y * gap_y <= limit:
                return False
            before_x, before_y = off_x, off_y
        return True

    def _update(self, now: float, errors: list[float]) -> list[str]:
        lines = []
        for robot, error in enumerate(errors, 1):
            found = self._open.get(robot)
            if error > self.limit:
                self._below.pop(robot, None)
                if found is None:
                    self.count += 1
                    cause = self._cause(robot, now)
                    text = cause.text if cause else NONE_FOUND
                    found = Excursion(self.count, robot, now, error, now, cause=text)
                    if cause:
                        found = replace(found, cause_at=cause.begins)
                    lines.append(f"robot {robot}: error above {1e3 * self.limit:.3g} mm; likely cause: {text}")
                elif error > found.peak:
                    found = replace(found, peak=error, peak_at=now)
                self._open[robot] = found
            elif found is not None:
                since = self._below.setdefault(robot, now)
                if now - since >= QUIET_SECONDS - 1e-9:
                    del self._below[robot], self._open[robot]
                    self._closed.append(self._over(found, since))
                    lines.append(f"robot {robot}: error below {1e3 * self.limit:.3g} mm again")
        return lines

    def _over(self, found: Excursion, until: float) -> Excursion:
        """An excursion that ended; the time to recover is from the end of its cause, or from its peak."""
        ends = [
            cause.ends
            for cause in self._causes
            if cause.ends is not None and cause.begins == found.cause_at and cause.text == found.cause
        ]
        since = next((end for end in ends if found.at <= end <= until), found.peak_at)
        return replace(found, until=until, recovery=until - since)

    def _cause(self, robot: int, now: float) -> _Cause | None:
        """What began last of that which acts, or acted lately, on the robot or upstream of it."""
        age = self._acted[robot].age if robot in self._acted else 0.0
        window = self._horizon + min(age, now - float(self._since[robot - 1]))
        possible = [
            cause
            for cause in self._causes
            if (cause.ends is None or cause.ends >= now - window) and self._reaches(cause, robot)
        ]
        return max(possible, key=lambda cause: (cause.begins, -self._hops(cause.robot, robot)), default=None)

    def _hops(self, one: int, other: int) -> int:
        """From a robot downstream to another."""
        return (other - one) % self._n

    def _reaches(self, cause: _Cause, robot: int) -> bool:
        """Whether a cause that acts upstream is near, or has shown at its own robot or the next.

        Where robot 1 alone knows the way, a link that fails leaves all behind it without, and robot 1 alone with them.
        """
        if not cause.robot or (self._told and cause.of_link and (robot >= cause.robot or robot == 1)):
            return True
        if self._hops(cause.robot, robot) <= max(1, min(HOPS, self._n - 2)):
            return True
        shown = (self._open.get(one) for one in (cause.robot, downstream(cause.robot, self._n)))
        return any(one is not None and one.at >= cause.begins for one in shown)

    def _note_causes(
        self, now: float, faults: Mapping[LinkId, Fault], disturbances: tuple[Disturbance, ...], live: Set[int]
    ) -> None:
        acting: dict[object, tuple[int, str]] = {
            (link, fault.words()): (link.receiver or link.sender, f"{link}: {fault.words()}")
            for link, fault in faults.items()
        }
        acting.update({id(entry): (entry.robot, f"robot {entry.robot}: {entry.words}") for entry in disturbances})
        if live:
            gone = set(range(1, self._n + 1)) - live
            acting.update({("gone", robot): (robot, f"agent {robot} is gone") for robot in sorted(gone)})
        for cause in self._causes:
            if cause.ends is None and cause.key not in acting:
                cause.ends = now
        known = {cause.key for cause in self._causes if cause.ends is None}
        self._causes += [_Cause(key, robot, text, now) for key, (robot, text) in acting.items() if key not in known]
        self._causes = [cause for cause in self._causes if cause.ends is None or cause.ends >= now - REMEMBERED]

    def _note_ring(self, now: float, away: Set[int], playing: Set[int]) -> None:
        """Who leaves the ring or joins it moves everybody's neighbours."""
        for robots, does in ((away - self._away, "leaves"), (self._away - away, "joins")):
            self._causes += [_Cause((does, robot), 0, f"robot {robot} {does}", now, now) for robot in sorted(robots)]
        for robot in playing - self._playing:
            self._since[robot - 1] = now
        self._away, self._playing = away, playing

    def newest(self, count: int) -> list[Excursion]:
        """The newest excursions, those that go on last."""
        both = [*self._closed, *self._open.values()]
        return sorted(both, key=lambda one: one.number)[-count:]

    def over_since(self, count: int) -> list[Excursion]:
        """Those that are over, but for the first `count` of them."""
        more = self.over - count
        return list(self._closed)[-more:] if more > 0 else []

    @property
    def over(self) -> int:
        """Excursions that are over."""
        return self.count - len(self._open)

    @property
    def going_on(self) -> list[Excursion]:
        """Excursions that are not over."""
        return list(self._open.values())

    def summary(self) -> dict[str, Any]:
        """For the summary of the episode."""
        return {
            "excursion_limit_m": self.limit,
            "never_within": sorted(self._never_within),
            "excursions": [
                {
                    "t": one.at,
                    "robot": one.robot,
                    "peak_m": one.peak,
                    "peak_t": one.peak_at,
                    "until": one.until,
                    "over_s": None if one.until is None else one.until - one.at,
                    "recovery_s": one.recovery,
                    "cause": one.cause,
                    "cause_t": one.cause_at,
                }
                for one in self.newest(KEPT)
            ],
        }
