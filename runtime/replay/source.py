"""A record as a source of what the page shows: it fills a tape, and answers no requests."""

from dataclasses import replace
from pathlib import Path
from time import monotonic

import numpy as np

from dashboard.telemetry.beliefs import Beliefs
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.origin import Localiser
from dashboard.telemetry.snapshot import Snapshot
from dashboard.telemetry.tape import Tape
from formation.arrays import FloatArray
from formation.errors import EchelonError
from runtime.replay.rows import Row, rows

LOADING_SECONDS = 0.015
"""Of one frame that rows are read for [s]: half of it, so that the page is answered meanwhile."""
NOTHING = Snapshot(None, None, {}, np.empty((0, 3)), 0.0, (), world_alive=True, connected=True)


class RecordSource:
    """One record, or two: the second is the ghost of the first."""

    live = False

    def __init__(self, file: Path, other: Path | None = None) -> None:
        """Read the first moment of each.

        Raises:
            EchelonError: a file is no record, or they have different numbers of robots.
        """
        self.name = file.stem
        self._compare = "" if other is None else other.stem
        self._rows, self._others = rows(file), iter(()) if other is None else rows(other)
        self._next: Row | None = next(self._rows, None)
        self._other = next(self._others, None)
        sizes = [len(row.state.poses) for row in (self._next, self._other) if row is not None]
        if not sizes:
            raise EchelonError(f"expected a record of a run; {file} has no moment of one")
        if len(set(sizes)) > 1:
            raise EchelonError(f"expected two records of as many robots; got {sizes[0]} and {sizes[1]}")
        self._localiser, self._believed = Localiser(), Beliefs()

    def start(self) -> None:
        """Nothing is received."""

    def stop(self) -> None:
        """Nothing was."""

    def update_scenario(self) -> None:
        """The record has it."""

    def snapshot(self) -> Snapshot:
        """There is no present."""
        return NOTHING

    def fill(self, tape: Tape, export_buffer: ExportBuffer) -> bool:
        """Read rows for LOADING_SECONDS; returns whether there are more."""
        end = monotonic() + LOADING_SECONDS
        while self._next is not None and monotonic() < end:
            self._add(self._next, tape, export_buffer)
            self._next = next(self._rows, None)
        return self._next is not None

    def _add(self, row: Row, tape: Tape, export_buffer: ExportBuffer) -> None:
        state, scenario, statuses = replace(row.state, compare=self._compare), row.scenario, row.statuses
        snapshot = self._localiser.local(
            Snapshot(state, scenario, statuses, state.poses, state.stamp, (), world_alive=True, connected=True)
        )
        beliefs, now = self._believed.update(snapshot), snapshot.state
        assert now is not None
        ghost = self._ghost(state.stamp, snapshot.origin)
        tape.add(now, scenario, snapshot.statuses, beliefs, ghost, snapshot.origin)
        export_buffer.add(now, ring_links(now, snapshot.statuses), snapshot.statuses, snapshot.origin)

    def _ghost(self, stamp: float, origin: FloatArray) -> FloatArray | None:
        """(n, 3) of the other record at this stamp; None beyond its end."""
        while self._other is not None and self._other.state.stamp < stamp - 1e-6:
            self._other = next(self._others, None)
        if self._other is None or self._other.state.stamp > stamp + 0.1:
            return None
        return np.asarray(self._other.state.poses - np.append(origin, 0.0))
