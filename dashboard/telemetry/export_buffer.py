"""The last minutes of an episode, kept for export, in simulated time; cleared at the start of every episode."""

import threading
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from dashboard.telemetry.links import LinkView
from dashboard.telemetry.origin import HERE
from formation.arrays import FloatArray
from network.messages import State, Status
from network.values import Event, Excursion

ROWS = 3000
ROW_SECONDS = 0.1
"""Simulated time between two rows, at least [s]: ROWS hold five minutes."""
KEPT_EVENTS = 500
KEPT_EXCURSIONS = 300
LOST, DEAD, HELD, CUT, AWAY = 1, 2, 4, 8, 16
"""Bits of a robot's flags: the link from it is lost or cut; it has no agent; it is stopped by the watchdog."""
_FLOATS = ("x", "y", "heading", "slot_x", "slot_y", "distance_error", "angle_error", "age", "solve")
"""Columns of every robot [m, rad, s]; `age` is that of the plan over the link from it, -1 if unknown."""

Flags = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]


@dataclass(frozen=True, slots=True)
class ExportData:
    """A copy of the buffer, in the order of time."""

    scenario: str
    controller: str
    robots: int
    t: FloatArray
    """(rows,) simulated time [s]."""
    tracking_error: FloatArray
    """(rows,) [m]."""
    values: Mapping[str, np.ndarray[tuple[int, ...], np.dtype[np.float32]]]
    """(rows, n) each, by name."""
    flags: Flags
    """(rows, n)."""
    events: tuple[Event, ...]
    origin: FloatArray
    """(2,) of all places here, in the scenario's coordinates [m]."""
    excursions: tuple[Excursion, ...]
    """Of the ledger, in their order; of those in the rows, the newest."""
    excursion_limit: float
    """[m]."""


class ExportBuffer:
    """Keeps the states of the world, at most ROWS of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._key: tuple[int, int] = (-1, 0)
        self._names = ("", "")
        self._origin = HERE
        self._count = 0
        self._times: FloatArray = np.zeros((ROWS, 2))
        self._floats = np.zeros((ROWS, 0, len(_FLOATS)), dtype=np.float32)
        self._flags: Flags = np.zeros((ROWS, 0), dtype=np.uint8)
        self._events: deque[Event] = deque(maxlen=KEPT_EVENTS)
        self._excursions: dict[int, Excursion] = {}
        """By number; one that goes on is replaced."""
        self._limit = 0.0
        self._newest = 0

    def add(
        self, state: State, links: list[LinkView], statuses: Mapping[int, Status], origin: FloatArray = HERE
    ) -> None:
        """Add the newest state; places are relative to the origin (2,) [m]."""
        with self._lock:
            if self._key != (state.episode, len(state.poses)):
                self._begin(state)
            top = max((event.number for event in state.events), default=0)
            if top < self._newest:  # another world process, which numbers events from 1
                self._newest = 0
            self._events.extend(event for event in state.events if event.number > self._newest)
            self._newest = top
            self._limit = state.excursion_limit
            self._excursions.update((one.number, one) for one in state.excursions)
            while len(self._excursions) > KEPT_EXCURSIONS:
                del self._excursions[min(self._excursions)]
            newest_row = self._times[(self._count - 1) % ROWS, 0] if self._count else -1.0
            if state.stamp == newest_row:  # paused: the newest state replaces the last row
                self._count -= 1
            elif state.stamp < newest_row + ROW_SECONDS - 1e-6:
                return
            row = self._count % ROWS
            self._count += 1
            self._names, self._origin = (state.scenario, state.controller), origin
            self._times[row] = state.stamp, state.tracking_error
            table = self._floats[row]
            table[:, 0:3], table[:, 3:5] = state.poses, state.slots[:, :2]
            table[:, 5], table[:, 6] = state.distance_errors, state.angle_errors
            senders = [link.sender - 1 for link in links]  # robots that are away have no link
            table[:, 7] = -1.0
            table[senders, 7] = [-1.0 if link.age is None else link.age for link in links]
            table[:, 8] = [statuses[i].solve if i in statuses else 0.0 for i in range(1, len(state.poses) + 1)]
            self._flags[row] = DEAD  # but for those that have an agent, and links have flags too
            self._flags[row, _rows(state.live, len(state.poses))] = 0
            self._flags[row, _rows(state.stopped, len(state.poses))] += HELD
            self._flags[row, _rows(state.away, len(state.poses))] += AWAY
            self._flags[row, senders] += np.array([LOST * link.lost + CUT * link.cut for link in links], dtype=np.uint8)

    def _begin(self, state: State) -> None:
        self._key = state.episode, len(state.poses)
        self._count = 0
        self._floats = np.zeros((ROWS, len(state.poses), len(_FLOATS)), dtype=np.float32)
        self._flags = np.zeros((ROWS, len(state.poses)), dtype=np.uint8)
        self._events.clear()
        self._excursions.clear()

    def data(self) -> ExportData | None:
        """A copy of the rows; None while there are none."""
        with self._lock:
            if not self._count:
                return None
            rows = np.arange(max(0, self._count - ROWS), self._count) % ROWS
            times, floats = self._times[rows], self._floats[rows]
            scenario, controller = self._names
            return ExportData(
                scenario=scenario,
                controller=controller,
                robots=self._key[1],
                t=times[:, 0],
                tracking_error=times[:, 1],
                values={name: np.ascontiguousarray(floats[:, :, i]) for i, name in enumerate(_FLOATS)},
                flags=self._flags[rows],
                events=tuple(event for event in self._events if event.stamp >= times[0, 0]),
                origin=self._origin,
                excursions=tuple(
                    one for _, one in sorted(self._excursions.items()) if one.until is None or one.until >= times[0, 0]
                ),
                excursion_limit=self._limit,
            )


def _rows(robots: Collection[int], n: int) -> list[int]:
    """Rows of these robots, of n."""
    return [robot - 1 for robot in robots if 1 <= robot <= n]
