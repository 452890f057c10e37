"""What the page shows: of the run as it is now, or of the moment on the tape that users look at."""

import math
from collections.abc import Callable
from time import monotonic
from typing import NamedTuple, Protocol

import numpy as np

from dashboard.telemetry.beliefs import Beliefs, BeliefView
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.ghost_track import COMPARED_SECONDS
from dashboard.telemetry.history import History
from dashboard.telemetry.links import LinkView, ring_links
from dashboard.telemetry.moment import Moment
from dashboard.telemetry.origin import Localiser
from dashboard.telemetry.playhead import Playhead
from dashboard.telemetry.series import INTERVAL, POINTS, TRAIL_INTERVAL, TRAIL_POINTS
from dashboard.telemetry.snapshot import Snapshot
from dashboard.telemetry.tape import Place, Tape
from formation.arrays import FloatArray
from network.messages import State

BELIEF_INTERVAL = 0.09
"""Between two looks at what robots believe [s]."""
WINDOW = POINTS * INTERVAL
"""Of the plots [s]."""
RECORD_BYTES = 1 << 30
"""Of a record that is shown, at most."""
AFTER = WINDOW / 3.0
"""Of the plots' window, after the moment that is looked at [s]."""


class Source(Protocol):
    """Where states and statuses come from: a run, or a record of one."""

    live: bool
    """Whether there is a run behind it that answers requests."""

    def start(self) -> None:
        """Begin to receive."""

    def stop(self) -> None:
        """Receive no more."""

    def snapshot(self) -> Snapshot:
        """What is known now."""

    def update_scenario(self) -> None:
        """Request the scenario, if it has changed."""

    def fill(self, tape: Tape, export_buffer: ExportBuffer) -> bool:
        """Without a run: add to the tape for a moment; returns whether there is more to add."""


class Ghosts(Protocol):
    """Where the ghost is, and was."""

    def poses(self, stamp: float) -> FloatArray | None:
        """(n, 3) at a stamp [s]; None without a ghost."""

    def trail(self, poses: FloatArray) -> FloatArray:
        """(n, TRAIL_POINTS, 2) ending at these poses [m]."""


class View(NamedTuple):
    """A moment, with all that is drawn of it."""

    snapshot: Snapshot
    links: list[LinkView]
    beliefs: list[BeliefView]
    trails: Callable[[FloatArray], FloatArray]
    """(n, TRAIL_POINTS, 2) up to poses (n, 3), oldest first [m]."""
    ghosts: Ghosts
    place: Place | None
    """On the tape; None for the present."""


class _GhostThen:
    """The ghost of a moment of the past."""

    def __init__(self, moment: Moment) -> None:
        self._poses = moment.ghost

    def poses(self, stamp: float) -> FloatArray | None:  # the moment has one
        return self._poses

    def trail(self, poses: FloatArray) -> FloatArray:
        return np.repeat(poses[:, None, :2], TRAIL_POINTS, axis=1)


class Feed:
    """Keeps what comes in, and gives the views that the page draws."""

    def __init__(self, source: Source) -> None:
        """Without anything received yet."""
        self.source = source
        self.history, self.export_buffer = History(), ExportBuffer()
        self.tape = Tape() if source.live else Tape(seconds=math.inf, most_bytes=RECORD_BYTES)
        self.playhead = Playhead(self.tape, live=source.live)
        self._localiser = Localiser()
        self._kept: tuple[State, bool] | None = None
        self._links: list[LinkView] = []
        self._believed, self._beliefs = Beliefs(), list[BeliefView]()
        self._believed_at = 0.0
        self._then: tuple[Place, View] | None = None
        self._whole: tuple[tuple[int, float], dict[str, FloatArray]] | None = None
        self.loading = not source.live
        """Whether more of a record is being read."""

    def now(self) -> View:
        """The run as it is, after adding it to plots, export and tape; of a record, the moment that is looked at."""
        if not self.source.live:
            return self._of_a_record()
        snapshot = self._localiser.local(self.source.snapshot())
        state, scenario = snapshot.state, snapshot.scenario
        if state is not None and scenario is not None:
            self.history.ghost.update(state, snapshot.ghosts)
        if monotonic() - self._believed_at >= BELIEF_INTERVAL:
            self._believed_at, self._beliefs = monotonic(), self._believed.update(snapshot)
        if state is not None and self._kept != (state, scenario is not None):
            self._kept = state, scenario is not None
            self._links = ring_links(state, snapshot.statuses)
            if scenario is not None:
                self.history.add(state, self._links, snapshot.statuses, self._beliefs)
                self.export_buffer.add(state, self._links, snapshot.statuses, snapshot.origin)
                ghost = self.history.ghost.poses(state.stamp) if state.compare else None
                self.tape.add(state, scenario, snapshot.statuses, self._beliefs, ghost, snapshot.origin)
        return View(snapshot, self._links, self._beliefs, self.history.trails, self.history.ghost, None)

    def _of_a_record(self) -> View:
        """The moment that is looked at, after reading on for a while."""
        if self.loading:
            self.loading = self.source.fill(self.tape, self.export_buffer)
        nothing = View(self.source.snapshot(), [], [], self.history.trails, self.history.ghost, None)
        return self._chosen(nothing)

    def shown(self, live: View) -> View:
        """What is looked at: the run as it is, unless a user chose a moment of the past."""
        return self._chosen(live) if self.source.live else live

    def _chosen(self, live: View) -> View:
        place = self.playhead.place(monotonic())
        if place is None:
            self._then = None
            return live
        if self._then is None or self._then[0] != place:
            moment = self.tape.moment(place)
            if moment is None:
                return live
            self._then = place, self._view(place, moment)
        return self._then[1]

    def _view(self, place: Place, moment: Moment) -> View:
        snapshot = moment.snapshot
        assert snapshot.state is not None

        def trails(poses: FloatArray) -> FloatArray:
            found = self.tape.trail(place, TRAIL_POINTS, TRAIL_INTERVAL)
            found[:, -1] = poses[:, :2]
            return found

        links = ring_links(snapshot.state, snapshot.statuses)
        views = [
            view._replace(offset=moment.offsets[view.receiver - 1])
            for view in Beliefs().update(snapshot)
            if np.isfinite(moment.offsets[view.receiver - 1]).all()
        ]
        return View(snapshot, links, views, trails, _GhostThen(moment), place)

    def series(self, view: View) -> dict[str, FloatArray]:
        """Columns of the plots around what is looked at."""
        if view.place is None:
            return self.history.series()
        episode = self.tape.episode(view.place.episode)
        if episode is None:
            return self.history.series()
        ends = min(max(view.place.stamp + AFTER, episode.begins + WINDOW), episode.ends)
        return self.tape.series(view.place.episode, ends - WINDOW, ends)

    def spans(self, view: View) -> list[tuple[float, float]]:
        """When faults and pushes acted in the episode that is looked at [s]."""
        episodes = self.tape.episodes
        episode = self.tape.episode(view.place.episode) if view.place else episodes[-1] if episodes else None
        return episode.marks.spans(episode.ends) if episode else []

    def compared(self, view: View) -> tuple[dict[str, FloatArray], float]:
        """Columns in which a run is compared with its ghost, and over how long [s]: a record as a whole."""
        if self.source.live or view.place is None:
            return self.series(view), COMPARED_SECONDS
        episode = self.tape.episode(view.place.episode)
        assert episode is not None
        key = (episode.number, episode.ends)
        if self._whole is None or self._whole[0] != key:
            self._whole = key, self.tape.series(episode.number, episode.begins, episode.ends)
        return self._whole[1], episode.ends - episode.begins
