"""An episode of a record as a simulation has it: every pose and input, and its summary."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from records.record import Record, RecordedEpisode
from runtime.verification import check_repeatable, difference_of, shadow_of
from world.measures.trace import Errors, Trace


@dataclass(frozen=True, slots=True, eq=False)
class Repeated:
    """What came of it."""

    scenario: Scenario
    poses: FloatArray
    """(T + 1, n, 3) [m, m, rad]."""
    inputs: FloatArray
    """(T, n, 2) [m/s, rad/s]."""
    ages: FloatArray
    """(T, n) of the plans that were acted on [s]."""
    errors: Errors
    """Over (T + 1,) rows, by the slots and the ring of each."""
    summary: dict[str, Any]


def repeat(record: Record, number: int = -1, *, warmup: float = 0.0) -> Repeated:
    """Simulate an episode of a record again: the record's own poses are checked on the way.

    Args:
        record: as it was read.
        number: of the episode, from 0; negative: counted from the last one.
        warmup: measures of the summary start there [s].

    Raises:
        EchelonError: it cannot be simulated again, is not there, does not begin at t = 0, or differs.
    """
    check_repeatable(record)
    try:
        episode = record.episodes[number]
    except IndexError:
        raise EchelonError(f"expected one of {len(record.episodes)} episodes in {record.path}; got {number}") from None
    _check_whole(record, episode)
    shadow = shadow_of(episode)
    world, last = shadow.world, episode.ticks[-1]
    trace = world.trace = Trace(world.scenario, last, world.reference)
    trace.start(world.plant.poses)
    if world.away:
        trace.close_over(world.away)
    for tick in episode.ticks:
        while shadow.k < tick:
            shadow.step()
        difference = difference_of(episode, tick, shadow)
        if difference:
            raise EchelonError(f"{record.path}: expected what was recorded; {difference}")
    shadow.hear_statuses()
    summary = {**world.summary(warmup=warmup), "engine": "record", "wall_s": 0.0}
    return Repeated(world.scenario, trace.poses, trace.inputs, np.array(trace.ages), trace.measured(), summary)


def _check_whole(record: Record, episode: RecordedEpisode) -> None:
    ticks = episode.ticks
    if not ticks or ticks[0] != 0:
        begins = f"begins at t = {ticks[0] * episode.interval:.2f} s" if ticks else "has no tick"
        raise EchelonError(f"expected a record from t = 0 on; {record.path} {begins}")
    lost = next((order for order in episode.sorted_orders if order.kind == "agents"), None)
    if lost is not None:
        raise EchelonError(
            f"expected a record in which every agent takes part; in {record.path} one is absent from "
            f"t = {lost.tick * episode.interval:.2f} s on: `echelon recording export` has its tables"
        )
