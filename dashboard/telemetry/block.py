"""Half a minute of an episode in flat arrays; a part of the tape."""

from collections.abc import Mapping
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np

from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.ghost_track import COLUMNS as GHOST_COLUMNS
from dashboard.telemetry.links import age_now
from formation.arrays import FloatArray
from formation.link_ids import LinkId
from formation.metrics import pattern_errors, wrapped
from formation.pattern import upstream
from formation.scenario.scenario import Scenario
from network.messages import State, Status
from network.values import NO_WAY, Event, LinkCounts, Motion

ROWS = 300
ROW_SECONDS = 0.1
"""Simulated time between two rows, at least [s]."""
PLAN_EVERY = 2
"""Rows for each row of plans and beliefs."""
Array = np.ndarray[tuple[int, ...], np.dtype[Any]]
_POSE, _SLOT, _GHOST = slice(0, 3), slice(3, 6), slice(6, 9)
_DISTANCE, _ANGLE, _AGE, _WAY_AGE, _SOLVE, _GAP, _LAG, _OFF, _, _END_X, _END_Y = range(9, 20)
_COLUMNS = 20
"""Of a robot's row: pose, slot, ghost, errors, ages, solve time, Nash gap, lag, where it believes the
robot upstream of it to be off from where that is, end of the told way."""
_KNOWN, _LOST, _CONVERGED = 1, 2, 4
"""Bits of a robot's flags: there is a status, its way is used up, its solver converged."""
_COUNTS = ("sent", "delivered", "lost", "late", "corrupt", "duplicated", "in_flight")
_BEGINS, _PLACED = 0, slice(1, 4)
"""Columns of a plan in single precision: when it begins since the block's first row [s], its pose."""
NOBODY = np.iinfo(np.uint16).max


class Block:
    """Some rows of one episode and scenario."""

    def __init__(self, state: State, scenario: Scenario) -> None:
        """Without rows, for robots and a horizon as here."""
        n, steps = len(state.poses), scenario.controller.horizon
        plans = ROWS // PLAN_EVERY
        self.count = 0
        self.times: FloatArray = np.zeros(ROWS)
        self.worst = np.zeros(ROWS, dtype=np.float32)
        """Largest distance error [m]."""
        self._scenario, self._steps = scenario, steps
        self._world = np.zeros((ROWS, 6), dtype=np.float32)
        """Pace, tracking error, least gap, centre."""
        self._robots = np.zeros((ROWS, n, _COLUMNS), dtype=np.float32)
        self._flags = np.zeros((ROWS, n), dtype=np.uint8)
        self._keeps_off = np.zeros((ROWS, n), dtype=np.uint16)
        self._counts = np.zeros((ROWS, n, len(_COUNTS) + 1), dtype=np.uint32)
        """Of the link to each robot, and its ticks that it did not answer in time."""
        self._placed = np.full((ROWS, 2, n, 4), np.nan, dtype=np.float32)
        self._inputs = np.zeros((plans, 2, n, steps, 2), dtype=np.float16)
        """Of each robot's plan, and of what it believes of the neighbour upstream."""
        self._way = np.full((plans, steps + 1, 2), np.nan, dtype=np.float32)
        """What robot 1 says of the path [m]."""
        self._rare: list[tuple[int, State]] = []
        """What changes seldom, from which row on: a state without its arrays."""
        self._origin: FloatArray = np.zeros(2)

    def fits(self, scenario: Scenario) -> bool:
        """Whether rows of this scenario belong here."""
        return scenario is self._scenario

    @property
    def bytes(self) -> int:
        """Of all arrays."""
        arrays = (value for value in vars(self).values() if isinstance(value, np.ndarray))
        return sum(array.nbytes for array in arrays)

    # ------------------------------------------------------------------ in

    def write(
        self,
        row: int,
        state: State,
        scenario: Scenario,
        statuses: Mapping[int, Status],
        beliefs: list[BeliefView],
        ghost: FloatArray | None,
        origin: FloatArray,
    ) -> None:
        """Write a row; dashboard/telemetry/tape.py has the arguments."""
        self._scenario, self._origin = scenario, origin
        self.times[row], self.worst[row] = state.stamp, np.abs(state.distance_errors).max()
        self._world[row] = state.pace, state.tracking_error, state.gap, *state.centre
        table, counts, flags, off = self._robots[row], self._counts[row], self._flags[row], self._keeps_off[row]
        table[:, _POSE], table[:, _SLOT] = state.poses, state.slots
        table[:, _GHOST] = np.nan if ghost is None else ghost
        table[:, _DISTANCE], table[:, _ANGLE] = state.distance_errors, state.angle_errors
        table[:, _OFF:] = np.nan
        flags[:] = off[:] = 0
        for belief in beliefs:
            table[belief.receiver - 1, _OFF : _OFF + 2] = belief.offset
        for robot, status in statuses.items():
            if 1 <= robot <= len(table) and status.episode == state.episode:
                i, found = robot - 1, status.counts
                table[i, _AGE:_OFF] = age_now(state, status), status.way_age, status.solve, status.gap, status.lag
                if status.lost and len(status.way):
                    table[i, _END_X:] = status.way[-1, 2:4]
                flags[i] = _KNOWN | _LOST * status.lost | _CONVERGED * status.converged
                off[i] = min(status.keeps_off, NOBODY)
                counts[i] = (*(min(getattr(found, name), 2**32 - 1) for name in _COUNTS), min(status.missed, 2**32 - 1))
        self._write_plans(row, state, statuses)
        rare = replace(
            state, seq=0, stamp=0.0, pace=0.0, tracking_error=0.0, gap=0.0, events=[], poses=_NONE, slots=_NONE
        )
        rare = replace(rare, centre=_NONE, distance_errors=_NONE, angle_errors=_NONE)
        if not self._rare or _seldom(self._rare[-1][1]) != _seldom(rare):
            self._rare.append((row, rare))

    def _write_plans(self, row: int, state: State, statuses: Mapping[int, Status]) -> None:
        """Where plans begin, and with some rows what they are."""
        placed, whole, n = self._placed[row], row % PLAN_EVERY == 0, len(state.poses)
        inputs, told = self._inputs[row // PLAN_EVERY], self._way[row // PLAN_EVERY]
        placed[:] = np.nan
        if whole:
            told[:] = np.nan
        for robot, status in statuses.items():
            if not 1 <= robot <= n or status.episode != state.episode:
                continue
            for kind, motion in enumerate((status.plan, status.believes)):
                if motion is not None and len(motion.inputs) == self._steps:
                    placed[kind, robot - 1, _BEGINS] = motion.begins - self.times[0]
                    placed[kind, robot - 1, _PLACED] = motion.pose
                    if whole:
                        inputs[kind, robot - 1] = motion.inputs
            if whole and robot == 1:
                way = status.way[: self._steps + 1, 2:4]
                told[: len(way)] = way

    # ------------------------------------------------------------------ out

    def _share(self, row: int, stamp: float) -> tuple[int, float]:
        """The row after this one, and how far a stamp is on the way to it."""
        after = min(row + 1, self.count - 1)
        gap = self.times[after] - self.times[row]
        return after, float(np.clip((stamp - self.times[row]) / gap, 0.0, 1.0)) if gap > 0.0 else 0.0

    def _between(self, row: int, stamp: float, columns: slice) -> FloatArray:
        """(n, 3) poses between two rows [m, m, rad]."""
        after, share = self._share(row, stamp)
        before = self._robots[row, :, columns].astype(float)
        moved = self._robots[after, :, columns] - before
        moved[:, 2] = wrapped(moved[:, 2])
        return np.asarray(before + share * moved)

    def state(self, row: int, stamp: float, events: list[Event]) -> tuple[State, Scenario, FloatArray]:
        """The state at a stamp from this row on, its scenario, and the local origin."""
        rare = next(state for first, state in reversed(self._rare) if first <= row)
        pace, tracking, gap, *centre = self._world[row].tolist()
        table = self._robots[row].astype(float)
        found = replace(
            rare,
            stamp=min(max(stamp, float(self.times[row])), float(self.times[min(row + 1, self.count - 1)])),
            pace=pace,
            tracking_error=tracking,
            gap=gap,
            events=events,
            poses=self._between(row, stamp, _POSE),
            slots=self._between(row, stamp, _SLOT),
            centre=np.array(centre),
            distance_errors=table[:, _DISTANCE],
            angle_errors=table[:, _ANGLE],
        )
        return found, self._scenario, self._origin

    def statuses(self, row: int) -> dict[int, Status]:
        """The statuses at a row, with the plans that were kept last."""
        rare = next(state for first, state in reversed(self._rare) if first <= row)
        plans, n, stamp = row // PLAN_EVERY, self._robots.shape[1], float(self.times[row])
        found = {}
        for i in np.flatnonzero(self._flags[row] & _KNOWN).tolist():
            values, flags, robot = self._robots[row, i].tolist(), int(self._flags[row, i]), i + 1
            *counts, missed = self._counts[row, i].tolist()
            plan, believes = (self._motion(row, kind, i) for kind in (0, 1))
            found[robot] = Status(
                sender=robot,
                seq=0,
                stamp=stamp,
                episode=rare.episode,
                link=LinkId(upstream(robot, n, rare.away), robot),
                age=values[_AGE],
                plan=plan,
                counts=LinkCounts(*counts),
                solve=values[_SOLVE],
                missed=missed,
                gap=values[_GAP],
                rejected=0,
                pid=0,
                converged=bool(flags & _CONVERGED),
                keeps_off=int(self._keeps_off[row, i]),
                way_age=values[_WAY_AGE],
                lost=bool(flags & _LOST),
                lag=values[_LAG],
                way=self._told(plans, robot, values),
                believes=believes,
            )
        return found

    def _motion(self, row: int, kind: int, i: int) -> Motion | None:
        """A robot's plan (0), or what it believes (1), with the inputs that were kept last."""
        placed, inputs = self._placed[row, kind, i].astype(float), self._inputs[row // PLAN_EVERY, kind, i]
        if not np.isfinite(placed[_BEGINS]):
            return None
        begins, interval = float(placed[_BEGINS] + self.times[0]), self._scenario.controller.prediction_interval
        return Motion(max(begins, 0.0), placed[_PLACED], interval, inputs.astype(float))

    def _told(self, plans: int, robot: int, values: list[float]) -> FloatArray:
        """A preview with the places alone: robot 1's as it was sent, of a robot that is lost the end."""
        places = self._way[plans] if robot == 1 else np.array([[values[_END_X], values[_END_Y]]])
        places = places[np.isfinite(places[:, 0])]
        if not len(places):
            return NO_WAY
        way = np.zeros((len(places), 6))
        way[:, 2:4] = places
        return way

    def ghost(self, row: int, stamp: float) -> FloatArray | None:
        """(n, 3) where the ghost was, if there was one [m, m, rad]."""
        found = self._between(row, stamp, _GHOST)
        return found if np.isfinite(found).all() else None

    def places(self, row: int) -> FloatArray:
        """(n, 2) where the robots were [m]."""
        return self._robots[row, :, :2].astype(float)

    def series(self, begins: float, ends: float) -> dict[str, FloatArray]:
        """Columns between two stamps; empty without rows there."""
        first, last = np.searchsorted(self.times[: self.count], [begins, ends + 1e-9])
        return self.series_of(slice(int(first), int(last))) if last > first else {}

    def series_of(self, rows: slice) -> dict[str, FloatArray]:
        """Columns of dashboard/telemetry/history.py but `event`, in their units."""
        table, known = self._robots[rows].astype(float), self._flags[rows] & _KNOWN
        distance = 1e3 * np.abs(table[..., _DISTANCE])
        age, solve = (1e3 * np.where(known, table[..., column], 0.0) for column in (_AGE, _SOLVE))
        off = 1e3 * np.nan_to_num(np.hypot(table[..., _OFF], table[..., _OFF + 1]))
        some = np.maximum(1, (known > 0).sum(axis=1))
        ghost = [np.full(len(table), np.nan)] * 3
        if np.isfinite(table[..., _GHOST]).any():
            distances, angles = pattern_errors(table[..., _GHOST], table[..., _SLOT])
            centre = np.hypot(*(table[..., 6:8].mean(axis=1) - self._world[rows, 3:5]).T)
            ghost = [
                1e3 * np.abs(distances).max(axis=1),
                np.degrees(np.abs(angles).max(axis=1)),
                1e3 * centre,
            ]
        return {
            "t": self.times[rows].copy(),
            "distance_max": distance.max(axis=1),
            "distance_mean": distance.mean(axis=1),
            "angle": np.degrees(np.abs(table[..., _ANGLE]).max(axis=1)),
            "tracking": 1e3 * self._world[rows, 1].astype(float),
            "age_max": age.max(axis=1),
            "age_mean": age.sum(axis=1) / some,
            "solve_max": solve.max(axis=1),
            "solve_mean": solve.sum(axis=1) / some,
            "off_max": off.max(axis=1),
            "off_mean": off.mean(axis=1),
            **dict(zip(GHOST_COLUMNS, ghost, strict=True)),
        }

    def offsets(self, row: int) -> FloatArray:
        """(n, 2) of each receiver, from where the robot upstream was to where it believed it to be [m]."""
        return self._robots[row, :, _OFF : _OFF + 2].astype(float)

    def counts_since(self, row: int, other: "Block", before: int) -> dict[int, LinkCounts]:
        """By receiver, what became of the plans to it since an earlier row, and how many are in flight at this one."""
        now, then = self._counts[row].astype(int), other._counts[before].astype(int)
        passed = np.maximum(now - then, 0)
        passed[:, _COUNTS.index("in_flight")] = now[:, _COUNTS.index("in_flight")]
        known = np.flatnonzero(self._flags[row] & _KNOWN).tolist()
        return {i + 1: LinkCounts(*passed[i, : len(_COUNTS)].tolist()) for i in known}

    def ages(self, begins: float, ends: float) -> FloatArray:
        """(rows, n) ages of the plans over the links to each robot between two stamps; NaN if unknown [s]."""
        rows = slice(*np.searchsorted(self.times[: self.count], [begins, ends + 1e-9]).tolist())
        return np.where(self._flags[rows] & _KNOWN, self._robots[rows, :, _AGE].astype(float), np.nan)


_NONE: FloatArray = np.zeros(0)


_seldom = attrgetter(
    *("revision", "scenario", "controller", "mode", "status", "waiting_for", "dismissed", "speed", "contacts", "live"),
    *("stopped", "faults", "compare", "driving", "rejected", "overruns"),
)
"""What a state has besides its arrays."""
