"""The last ten minutes of a run in flat arrays, so that any moment of them can be shown again, of earlier episodes too.

A row is kept for every tenth of a second of simulated time, plans and beliefs with every other row, in single and half
precision, relative to the local origin. Rows stand in blocks of half a minute, of which the oldest is dropped. Ten
minutes of 20 robots are 31 MB.
"""

from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.block import ROW_SECONDS, ROWS, Block
from dashboard.telemetry.marks import Mark, Marks
from dashboard.telemetry.moment import Moment
from dashboard.telemetry.snapshot import Snapshot
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from network.messages import State, Status
from network.values import Event, LinkCounts

KEPT_SECONDS = 600.0
"""What is kept of the run, in simulated time [s]."""
KEPT_BYTES = 48 << 20
"""With many robots less is kept: at most so many bytes."""
KEPT_EVENTS = 2000
"""Of an episode."""
SHOWN_EVENTS = 40
"""Of a moment, the newest."""
TRACE_POINTS = 240


class Episode:
    """The part of the tape that one episode has."""

    def __init__(self, number: int, state: State) -> None:
        self.number = number
        """On the tape, from 1; the run's own number of it begins anew when its world does."""
        self.size = len(state.poses)
        self.run_number = state.episode
        self.blocks: deque[Block] = deque()
        self.events: deque[Event] = deque(maxlen=KEPT_EVENTS)
        self.marks = Marks()
        self._newest = 0

    @property
    def begins(self) -> float:
        """Of the first row that is kept [s]."""
        return float(self.blocks[0].times[0])

    @property
    def ends(self) -> float:
        """Of the newest row [s]."""
        block = self.blocks[-1]
        return float(block.times[block.count - 1])

    def note(self, state: State) -> None:
        """Take the events and faults of a state."""
        for event in state.events:
            if event.number > self._newest:
                self.events.append(event)
                self.marks.take_event(event)
        self._newest = max([self._newest, *(event.number for event in state.events)])
        self.marks.take_state(state)

    def row_at(self, stamp: float) -> tuple[Block, int]:
        """The last row that is not after a stamp [s], or the first that is kept."""
        for block in reversed(self.blocks):
            if block.times[0] <= stamp:
                return block, max(0, int(np.searchsorted(block.times[: block.count], stamp, side="right")) - 1)
        return self.blocks[0], 0


class Place(NamedTuple):
    """A moment on the tape."""

    episode: int
    """Number on the tape."""
    stamp: float
    """[s]."""


class Tape:
    """The episodes that are kept, the oldest first."""

    def __init__(self, seconds: float = KEPT_SECONDS, most_bytes: int = KEPT_BYTES) -> None:
        """An empty tape that keeps so much of simulated time [s], and so many bytes, at most."""
        self.episodes: list[Episode] = []
        self._seconds, self._most_bytes = seconds, most_bytes
        self._count = 0

    @property
    def bytes(self) -> int:
        """Of all arrays."""
        return sum(block.bytes for episode in self.episodes for block in episode.blocks)

    def add(
        self,
        state: State,
        scenario: Scenario,
        statuses: Mapping[int, Status],
        beliefs: list[BeliefView],
        ghost: FloatArray | None,
        origin: FloatArray,
    ) -> None:
        """Add the newest state.

        Args:
            state: of the world, relative to the local origin.
            scenario: of the episode.
            statuses: of the agents.
            beliefs: of the robots; only their errors are kept, with what the statuses say.
            ghost: (n, 3) where the ghost is at this stamp, if there is one [m, m, rad].
            origin: (2,) the local origin [m].
        """
        episode = self.episodes[-1] if self.episodes else None
        if episode is None or self._is_another(episode, state):
            self._count += 1
            episode = Episode(self._count, state)
            self.episodes.append(episode)
        episode.note(state)
        block = episode.blocks[-1] if episode.blocks else None
        if block is not None and state.stamp < block.times[block.count - 1] + ROW_SECONDS - 1e-6:
            if state.stamp == block.times[block.count - 1]:  # paused: the newest state replaces the last row
                block.write(block.count - 1, state, scenario, statuses, beliefs, ghost, origin)
            return
        if block is None or block.count == ROWS or not block.fits(scenario):
            block = Block(state, scenario)
            episode.blocks.append(block)
            self._trim()
        block.count += 1
        block.write(block.count - 1, state, scenario, statuses, beliefs, ghost, origin)

    def _is_another(self, episode: Episode, state: State) -> bool:
        same = (episode.run_number, episode.size) == (state.episode, len(state.poses))
        return not same or (bool(episode.blocks) and state.stamp < episode.ends - 1.0)

    def _trim(self) -> None:
        """Drop the oldest blocks while there is more than may be kept."""
        blocks = sum(len(episode.blocks) for episode in self.episodes)
        while blocks > 1 and ((blocks - 2) * ROWS * ROW_SECONDS >= self._seconds or self.bytes > self._most_bytes):
            oldest = self.episodes[0]
            oldest.blocks.popleft()
            blocks -= 1
            if not oldest.blocks:
                self.episodes.pop(0)

    # ------------------------------------------------------------------ what is on it

    def episode(self, number: int) -> Episode | None:
        """The episode of this number on the tape, while it is kept."""
        return next((episode for episode in self.episodes if episode.number == number), None)

    def nearest(self, place: Place) -> Place | None:
        """The place on the tape that is nearest to one that may have been dropped; None while there is none."""
        if not self.episodes:
            return None
        episode = self.episode(place.episode)
        if episode is None:
            first = self.episodes[0]
            return Place(first.number, first.begins)
        return Place(episode.number, float(min(max(place.stamp, episode.begins), episode.ends)))

    def moment(self, place: Place) -> Moment | None:
        """What was known at a place; None if it is not on the tape."""
        episode = self.episode(place.episode)
        if episode is None or not episode.blocks:
            return None
        block, row = episode.row_at(place.stamp)
        events = [event for event in episode.events if event.stamp <= place.stamp + 1e-9][-SHOWN_EVENTS:]
        state, scenario, origin = block.state(row, place.stamp, events)
        statuses = block.statuses(row)
        snapshot = Snapshot(state, scenario, statuses, state.poses, state.stamp, (), True, True, origin)
        return Moment(snapshot, block.ghost(row, place.stamp), block.offsets(row))

    def mark_after(self, place: Place, *, back: bool = False) -> Place | None:
        """The next mark after a place, or the last before it; None if there is none."""
        places = [Place(episode.number, mark.stamp) for episode in self.episodes for mark in episode.marks.all]
        if back:
            return next((one for one in sorted(places, reverse=True) if one < (place.episode, place.stamp - 0.3)), None)
        return next((one for one in sorted(places) if one > (place.episode, place.stamp + 0.05)), None)

    def marks(self) -> list[tuple[int, Mark]]:
        """All marks, with the number of their episode."""
        return [(episode.number, mark) for episode in self.episodes for mark in episode.marks.all]

    # ------------------------------------------------------------------ over time

    def trail(self, place: Place, points: int, seconds: float) -> FloatArray:
        """(n, points, 2) where the robots were up to a place, oldest first, `seconds` apart [m]."""
        episode = self.episode(place.episode)
        assert episode is not None
        stamps = place.stamp - seconds * np.arange(points)[::-1]
        return np.stack([block.places(row) for block, row in (episode.row_at(stamp) for stamp in stamps)], axis=1)

    def series(self, number: int, begins: float, ends: float) -> dict[str, FloatArray]:
        """Columns of dashboard/telemetry/history.py over part of an episode, in their units."""
        episode = self.episode(number)
        assert episode is not None
        parts = [part for block in episode.blocks if (part := block.series(begins, ends))]
        found = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else {}
        if not found or len(found["t"]) < 2:
            block, row = episode.row_at(ends)
            found = {name: np.repeat(value, 2) for name, value in block.series_of(slice(row, row + 1)).items()}
            found["t"] = found["t"] + [0.0, ROW_SECONDS]
        marks = [mark.stamp for mark in episode.marks.all]
        rows = np.searchsorted(found["t"], [at for at in marks if found["t"][0] <= at <= found["t"][-1]])
        found["event"] = np.zeros(len(found["t"]))
        found["event"][rows] = 1.0
        return found

    def links(self, place: Place, seconds: float) -> tuple[FloatArray, dict[int, LinkCounts], float]:
        """What went over the links in the last seconds up to a place.

        Returns:
            (rows, n) ages of the plans over the link to each robot, NaN if unknown [s]; by receiver, what became of the
            plans; and how long that was [s].
        """
        episode = self.episode(place.episode)
        assert episode is not None
        begins = max(place.stamp - seconds, episode.begins)
        parts = [block.ages(begins, place.stamp) for block in episode.blocks if block.times[0] <= place.stamp]
        (first, early), (last, late) = episode.row_at(begins), episode.row_at(place.stamp)
        counts = last.counts_since(late, first, early)
        return np.concatenate(parts), counts, float(last.times[late] - first.times[early])

    def trace(self) -> dict[int, FloatArray]:
        """By episode, the largest distance error (points, 2) of each part of it: stamps [s] and errors [m]."""
        rows = sum(block.count for episode in self.episodes for block in episode.blocks)
        every = max(1, -(-rows // TRACE_POINTS))
        found = {}
        for episode in self.episodes:
            times = np.concatenate([block.times[: block.count] for block in episode.blocks])
            worst = np.concatenate([block.worst[: block.count] for block in episode.blocks])
            starts = np.arange(0, len(times), every)
            found[episode.number] = np.column_stack([times[starts], np.maximum.reduceat(worst, starts)])
        return found
