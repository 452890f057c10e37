"""The recorded episode, tick by tick, and the summary that `echelon run` prints of it."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from formation.arrays import BoolArray, FloatArray, timeline
from formation.driving.reference import DrivenReference
from formation.link_ids import LinkId
from formation.metrics import pattern_errors, quantiles, rms, tracking_error, tracking_error_of_some
from formation.reference import Reference
from formation.scenario.scenario import Scenario
from network.messages import Command
from network.values import Event, LinkCounts
from world.measures.contacts import AtLimits
from world.measures.convergence import Convergence


class Errors(NamedTuple):
    """Errors of an episode over time, and where its centre should have been: by the slots and the ring of each tick."""

    distance: FloatArray
    """(T, n) l_e of each robot and its upstream neighbour in the ring [m]; NaN while the robot is away."""
    angle: FloatArray
    """(T, n) psi_e [rad]; NaN likewise."""
    tracking: FloatArray
    """(T,) distance of the mean position of those in the ring to where it should be [m]."""
    centre: FloatArray
    """(T, 2) the reference p_r, where the formation's centre should be [m]."""


class Trace:
    """Poses, ages and solve times of one episode of known length."""

    def __init__(self, scenario: Scenario, ticks: int, reference: Reference | DrivenReference) -> None:
        self._scenario, self.reference = scenario, reference
        self._ticks, self._done = ticks, 0
        self._rings: list[tuple[int, frozenset[int]]] = [(0, frozenset())]
        """Rows from which on the ring is closed over robots, and these."""
        self._make(scenario.size)

    @property
    def full(self) -> bool:
        """Whether the episode has reached its last tick."""
        return self._done == len(self._ages)

    def start(self, poses: FloatArray) -> None:
        """Record the poses (n, 3) at t = 0."""
        self._poses[0] = poses

    def add(
        self, poses: FloatArray, inputs: FloatArray, commands: Mapping[int, Command], planned: Iterable[int]
    ) -> None:
        """Record a tick: the poses (n, 3) after it, the commanded inputs (n, 2), the agents' commands, who planned."""
        k = self._done
        ages, solves = self._ages[k], self._solves[k]
        for robot, command in commands.items():
            ages[robot - 1] = command.age
        for robot in planned:
            solves[robot - 1] = commands[robot].solve
        self._poses[k + 1] = poses
        self._inputs[k] = inputs
        self._done = k + 1

    def without_rows(self) -> dict[str, Any]:
        """Its state, all but the rows: these only grow, `rows` has them, and `refill` takes them."""
        return {**self.__dict__, **dict.fromkeys(("_poses", "_inputs", "_ages", "_solves"))}

    def rows(self, first: int) -> FloatArray:
        """Rows (T, 7 n) from number `first` on: poses, then inputs, ages and solve times of the tick that led there."""
        k, n = self._done, self._scenario.size
        rows = np.full((k + 1 - first, 7 * n), np.nan)
        rows[:, : 3 * n] = self._poses[first : k + 1].reshape(-1, 3 * n)
        led, since = rows[max(1 - first, 0) :], max(first - 1, 0)
        led[:, 3 * n : 5 * n] = self._inputs[since:k].reshape(-1, 2 * n)
        led[:, 5 * n : 6 * n], led[:, 6 * n :] = self._ages[since:k], self._solves[since:k]
        return rows

    def refill(self, rows: FloatArray, k: int) -> None:
        """Take the rows 0 to k of another process's trace of the episode, flat. Raises ValueError if they are fewer."""
        n = self._scenario.size
        rows = rows[: (k + 1) * 7 * n].reshape(k + 1, 7 * n)
        self._make(n)
        self._poses[: k + 1] = rows[:, : 3 * n].reshape(-1, n, 3)
        self._inputs[:k] = rows[1:, 3 * n : 5 * n].reshape(-1, n, 2)
        self._ages[:k], self._solves[:k] = rows[1:, 5 * n : 6 * n], rows[1:, 6 * n :]
        self._done = k

    def _make(self, n: int) -> None:
        ticks = self._ticks
        self._poses = np.zeros((ticks + 1, n, 3))
        self._inputs = np.zeros((ticks, n, 2))
        self._ages = np.full((ticks, n), np.nan)
        self._solves = np.full((ticks, n), np.nan)

    def close_over(self, away: frozenset[int]) -> None:
        """From now on the ring is closed over these robots: they have no errors."""
        self._rings.append((self._done, away))

    @property
    def times(self) -> FloatArray:
        """(T + 1,) of `poses` [s]."""
        return timeline(0, self._done + 1, self._scenario.control_interval)

    @property
    def poses(self) -> FloatArray:
        """(T + 1, n, 3) true poses from t = 0 on [m, m, rad]."""
        return self._poses[: self._done + 1]

    @property
    def inputs(self) -> FloatArray:
        """(T, n, 2) commanded inputs, tick by tick [m/s, rad/s]."""
        return self._inputs[: self._done]

    @property
    def ages(self) -> FloatArray:
        """(T, n) age of the plan that each robot acted on; NaN without an answer [s]."""
        return self._ages[: self._done]

    def errors(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """l_e (T + 1, n) [m], psi_e (T + 1, n) [rad] and the centre's distance to the path (T + 1,) [m].

        Robots that are away have no errors: zero. What the others' mean is far from is then the mean of their slots.
        """
        return self._errors(0)

    def measured(self, first: int = 0, stop: int | None = None) -> Errors:
        """The same of rows `first` to `stop` - 1 (of all), NaN instead of zero, with the reference of the centre."""
        distance, angle, tracking = self._errors(first, stop)
        gone = ~self.present[first:stop]
        distance[gone] = angle[gone] = np.nan
        return Errors(distance, angle, tracking, self.reference.centre(self.times[first:stop]))

    def _errors(self, first: int, stop: int | None = None) -> tuple[FloatArray, FloatArray, FloatArray]:
        t, poses = self.times[first:stop], self.poses[first:stop]
        slots = self.reference.positions(t)
        distance, angle = pattern_errors(poses, slots)
        tracking = tracking_error(poses, self.reference.centre(t))
        for begin, end, away in self._closed():
            rows = slice(max(0, begin - first), max(0, end - first))
            distance[rows], angle[rows] = pattern_errors(poses[rows], slots[rows], away)
            tracking[rows] = tracking_error_of_some(poses[rows], slots[rows], away)
        return distance, angle, tracking

    def _closed(self) -> list[tuple[int, int, frozenset[int]]]:
        """Where the ring was closed over robots: the first row, the one after the last, and the robots."""
        ends = [*(begin for begin, _ in self._rings[1:]), self._done + 1]
        return [
            (begin, end, away) for (begin, away), end in zip(self._rings, ends, strict=True) if away and end > begin
        ]

    @property
    def present(self) -> BoolArray:
        """(T + 1, n): whether each robot was in the ring; one that was away has no errors."""
        found = np.ones(self.poses.shape[:2], dtype=bool)
        for begin, end, away in self._closed():
            found[begin:end, [robot - 1 for robot in away]] = False
        return found

    def _present(self, robot: int, first: int) -> "slice | FloatArray":
        """Rows from `first` on in which a robot takes part: all, or a mask."""
        gone = [(begin, end) for begin, end, away in self._closed() if robot in away]
        if not gone:
            return slice(None)
        rows = np.ones(self._done + 1, dtype=bool)
        for begin, end in gone:
            rows[begin:end] = False
        return rows[first:]

    def summary(
        self,
        counts: Mapping[LinkId, LinkCounts],
        convergence: Convergence,
        at_limits: AtLimits,
        events: Sequence[Event],
        *,
        warmup: float = 0.0,
    ) -> dict[str, Any]:
        """The summary of the episode so far (docs/design.md, section 8), without rounding.

        Args:
            counts: by link.
            convergence: of the agents' solvers.
            at_limits: of the robots, in the whole episode.
            events: in the order in which they happened.
            warmup: measures start at this simulated time [s].
        """
        scenario, done = self._scenario, self._done
        first = min(done, max(0, round(warmup / scenario.control_interval)))
        distance, angle, tracking = self._errors(first)
        ages = self._ages[first:done]
        solves = self._solves[first:done]
        return {
            "scenario": scenario.name,
            "controller": scenario.controller.name,
            "seed": scenario.seed,
            "duration": done * scenario.control_interval,
            "warmup": first * scenario.control_interval,
            "ticks": done,
            "trajectory_sha256": hashlib.sha256(self.poses.astype("<f8").tobytes()).hexdigest(),
            "robots": {
                str(i + 1): {
                    "distance_error_m": _spread(distance[self._present(i + 1, first), i]),
                    "angle_error_rad": _spread(angle[self._present(i + 1, first), i]),
                    "converged": convergence.share(i + 1),
                    **at_limits.summary(i + 1),
                }
                for i in range(scenario.size)
            },
            "tracking_error_m": _spread(tracking),
            "reference_lag_s": self.reference.lag(done * scenario.control_interval),
            "links": {
                str(link): {
                    "sent": c.sent,
                    "delivered": c.delivered,
                    "lost": c.lost,
                    "late": c.late,
                    "corrupt": c.corrupt,
                    "duplicated": c.duplicated,
                    "in_flight": c.in_flight,
                    "age_s": _ages(ages[:, link.receiver - 1]),
                }
                for link, c in counts.items()
            },
            "solve_s": dict(zip(("median", "p99"), quantiles(solves, 0.5, 0.99), strict=True)),
            "events": [{"t": e.stamp, "kind": e.kind, "severity": e.severity, "text": e.text} for e in events],
        }


def _spread(signed: FloatArray) -> dict[str, float | None]:
    """Statistics of the absolute value; `final` keeps its sign."""
    if not len(signed):
        return dict.fromkeys(("rms", "median", "q1", "q3", "p95", "max", "final"))
    size = np.abs(signed)
    q1, median, q3, p95 = quantiles(size, 0.25, 0.5, 0.75, 0.95)
    return {
        "rms": rms(size),
        "median": median,
        "q1": q1,
        "q3": q3,
        "p95": p95,
        "max": float(size.max()),
        "final": float(signed[-1]),
    }


def _ages(ages: FloatArray) -> dict[str, float | None]:
    return dict(zip(("median", "p95", "max"), quantiles(ages, 0.5, 0.95, 1.0), strict=True))
