"""Whether a tick can be one of a scenario: what is wrong with one that cannot."""

from formation.errors import WireError
from formation.scenario.scenario import Scenario
from network.messages import Tick


def check(tick: Tick, scenario: Scenario) -> None:
    """Raises WireError: numbers of robots, the measured tick or the stamp do not fit."""
    if len(tick.odometry) != scenario.size:
        raise WireError(f"expected odometry of {scenario.size} robots; got {len(tick.odometry)}")
    n = scenario.size
    if (tick.measured is not None and len(tick.poses) != n) or len(tick.relatives) not in (0, n):
        raise WireError(f"expected measurements of {n} robots; got {len(tick.poses)} and {len(tick.relatives)}")
    if len(tick.seen) not in (0, n * n):
        raise WireError(f"expected sightings of {n} robots by {n}; got {len(tick.seen)}")
    if tick.measured is not None and tick.measured > tick.seq:
        raise WireError(f"expected a measurement of tick {tick.seq} or before; got one of {tick.measured}")
    if abs(tick.seq * scenario.control_interval - tick.stamp) > 1e-6:
        raise WireError(f"expected stamp {tick.seq * scenario.control_interval:g} s; got {tick.stamp:g} s")
