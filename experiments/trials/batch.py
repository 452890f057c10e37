"""A batch of work from start to end: on a pool of processes or a cluster, what an earlier run has left undone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.trials import pool
from experiments.trials.journal import Journal
from experiments.trials.pool import Progress, Work
from runtime.precompile import ensure_compiled


@dataclass(frozen=True, slots=True)
class Place:
    """Where the work is done, and where its journal is."""

    folder: Path
    """Made if it is not there; holds the journal."""
    workers: int | None = None
    """Processes of this machine, unless there is a cluster; one per core, if None."""
    cluster: str | None = None
    """Address of the scheduler of a Dask cluster."""

    @property
    def cores(self) -> int | None:
        """How many cores work; None on a cluster."""
        return None if self.cluster else min(self.workers or pool.cores(), pool.cores())


def run_batch(
    work: Sequence[Work],
    place: Place,
    *,
    noun: str = "trials",
    tell: Callable[[str], None],
    progress: Progress,
) -> list[dict[str, Any]]:
    """Results of all work, in its order; only what the folder's journal lacks is done.

    Args:
        work: what is wanted.
        place: where it is done.
        noun: what a piece of it is called, as a plural.
        tell: called with lines for the user.
        progress: called for each piece whose result is there.

    Raises:
        EchelonError: the folder cannot be written, there is no such cluster, or a piece failed.
    """
    workers = pool.local(place.workers or pool.cores()) if place.cluster is None else pool.cluster(place.cluster)
    if place.cluster is None:
        ensure_compiled(tell)
    with Journal(place.folder) as journal:
        there = sum(piece.key in journal.results for piece in work)
        if there:
            tell(f"{there} of {len(work)} {noun} are in {place.folder} already")
        return pool.finish(work, journal, workers, progress)
