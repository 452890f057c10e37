"""A world's saved state in a folder: written again each second of simulated time, when it stands, and for users."""

import os
from pathlib import Path

import numpy as np

from world.parts import Parts
from world.resume.snapshot import SnapshotError, dump, load

SECONDS = 1.0
"""Simulated time that is lost at most [s]."""
RUN, TRACE = "world.save", "trace"
"""Names of the files: the run, replaced as a whole; and of an episode of known length its trace, which only grows."""


class Saver:
    """Keeps a folder in step with a run."""

    def __init__(self, folder: Path) -> None:
        """Nothing saved yet; the folder exists."""
        self._folder = folder
        self._saved: tuple[int, int, frozenset[int]] | None = None
        """Episode, number of changes by users, and who took part."""
        self._k = self._rows = 0
        """The tick, and the rows of the trace, that were saved last."""
        self._failed = False

    def look(self, parts: Parts) -> None:
        """Save, if it is time; before what the run has just decided is published, or answered.

        A run that stands shows one moment for good: that one is saved, and not one up to a second before.
        """
        world = parts.world
        key = world.episode, parts.control.changes, frozenset(world.live)
        ticks = world.k - self._k
        recent = ticks * world.scenario.control_interval < SECONDS - 1e-9
        if self._saved == key and (ticks == 0 or (recent and parts.control.active)):
            return
        try:
            self._write(parts, begins=self._saved is None or self._saved[0] != world.episode)
            self._failed = False
        except OSError as error:
            if not self._failed:
                self._failed = True
                text = f"the run cannot be saved ({error.strerror}): it would not outlive this process"
                world.event("run", text, "warning")
        self._saved, self._k = key, world.k

    def _write(self, parts: Parts, *, begins: bool) -> None:
        world = parts.world
        kept = set()
        if world.trace is not None:
            file = self._folder / f"{TRACE}-{world.episode}"
            rows = world.trace.rows(0 if begins else self._rows)
            with file.open("wb" if begins else "ab") as out:
                out.write(rows.astype("<f8").tobytes())
            self._rows = world.k + 1
            kept.add(file.name)
        new = self._folder / f"{RUN}.new"
        new.write_bytes(dump(parts))
        new.replace(self._folder / RUN)
        if begins:
            for old in self._folder.glob(f"{TRACE}-*"):
                if old.name not in kept:
                    old.unlink(missing_ok=True)


def saved(folder: Path) -> Parts | None:
    """The run that was saved in a folder, ready to go on; None if there is none.

    Raises:
        SnapshotError: what is there cannot be read.
    """
    try:
        data = (folder / RUN).read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise SnapshotError(f"expected a saved run; {os.fspath(folder)} cannot be read: {error.strerror}") from None
    parts, bodies = load(data)
    world = parts.world
    if world.trace is not None:
        _read_trace(parts, folder / f"{TRACE}-{world.episode}")
    parts.go_on()
    if not bodies:
        world.reset()
        text = f"the state of the bodies {world.scenario.bodies.implementation} was not saved: a new episode"
        world.event("run", text, "warning")
    return parts


def _read_trace(parts: Parts, file: Path) -> None:
    world = parts.world
    assert world.trace is not None
    try:
        world.trace.refill(np.fromfile(file, dtype="<f8"), world.k)
    except (OSError, ValueError) as error:
        raise SnapshotError(f"expected the trace of a saved run; got {type(error).__name__}: {error}") from None
