"""Whether a tick can be one of a scenario, and the newest that the world has sent."""

from formation.arrays import FloatArray
from formation.errors import WireError
from formation.scenario.scenario import Scenario
from network.messages import Tick
from network.requests import Setup

MAX_AHEAD = 1.0
"""A message may be stamped this far ahead of the newest tick [s]."""


def is_believable(tick: Tick, setup: Setup, scenario: Scenario, *, answered: int, newest: float) -> bool:
    """Whether the tick can be the world's newest, by what an agent knows: one that cannot needs a new Setup.

    In lockstep the world waits for this agent, so the next tick is the one after that which it answered, unless the
    world went on without it.

    Args:
        tick: of the Setup's episode.
        setup: the newest.
        scenario: of the Setup.
        answered: tick that was answered last, -1 before the first.
        newest: stamp of the newest tick that was believed [s].
    """
    if setup.mode == "lockstep":
        return tick.seq <= max(answered + 1, round(setup.stamp / scenario.control_interval))
    return tick.stamp <= max(newest, setup.stamp) + MAX_AHEAD


def check(tick: Tick, scenario: Scenario) -> None:
    """Raises WireError: numbers of robots, the measured tick or the stamp do not fit."""
    if len(tick.odometry) != scenario.size:
        raise WireError(f"expected odometry of {scenario.size} robots; got {len(tick.odometry)}")
    n = scenario.size
    if (tick.measured is not None and len(tick.poses) != n) or len(tick.relatives) not in (0, n):
        raise WireError(f"expected measurements of {n} robots; got {len(tick.poses)} and {len(tick.relatives)}")
    if len(tick.seen) and not _ascending(tick.seen[:, 0], n * n):
        raise WireError(f"expected sightings of {n} robots by {n} in ascending order")
    if tick.measured is not None and tick.measured > tick.seq:
        raise WireError(f"expected a measurement of tick {tick.seq} or before; got one of {tick.measured}")
    if abs(tick.seq * scenario.control_interval - tick.stamp) > 1e-6:
        raise WireError(f"expected stamp {tick.seq * scenario.control_interval:g} s; got {tick.stamp:g} s")


def _ascending(numbers: FloatArray, end: int) -> bool:
    """Whether they are whole numbers from 0 on, below `end`, each larger than the one before."""
    whole = not (numbers % 1.0).any()
    return whole and numbers[0] >= 0.0 and numbers[-1] < end and bool((numbers[1:] > numbers[:-1]).all())
