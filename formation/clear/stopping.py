"""How fast a robot may come nearer to a body, so that it stops in time (docs/theory.md, section 19).

agents/kernels/nearby/avoidance.py holds commands to it, and formation/scenario/scenario.py what slots ask for.
"""

import math
from collections.abc import Sequence

from formation.bodies.nominal import Nominal

RESPONSE = 0.1
"""Time in which closing speeds fade, beyond the delay of commands [s]."""
YIELDS, INSISTS = 0.010, 0.006
"""Distance of two bodies that the robot with the higher number keeps, and the one with the lower [m]."""
ORDERLY = 0.25
"""Neither keeps more than this share of the distance that neighbours' bodies have in the formation."""
ENDLESS = 1e6
"""Wheels that can change their speed faster have no limit [m/s2]."""
SLOWEST = 0.1
"""Slots may ask for this share of a robot's speed, however little room there is."""


def stopping_speed(gap: float, react: float, brake: float) -> float:
    """The closing speed s from which one stops within a gap: s react + s^2 / (2 brake) = gap; below 0 if gap is.

    Args:
        gap: that is left [m].
        react: time until one brakes [s].
        brake: deceleration from then on [m/s2].
    """
    if gap <= 0.0 or brake > ENDLESS:
        return gap / react
    return brake * (math.sqrt(react * react + 2.0 * gap / brake) - react)


def top_speed(v_max: float, spacing: float, radii: Sequence[float], body: Nominal, tick: float) -> float:
    """The largest speed at which a robot stops in time behind one that stops at once, where neighbours are [m/s].

    Args:
        v_max: limit of |v| [m/s].
        spacing: of neighbours in the formation [m].
        radii: (n,) of the bodies [m].
        body: what may be known of all.
        tick: delta_t [s].
    """
    room = spacing - sum(sorted(radii)[-2:])
    gap = room - min(YIELDS, ORDERLY * room)
    brake = min(body.acceleration, v_max / max(body.lag, 1e-9))
    return min(v_max, max(stopping_speed(gap, RESPONSE + body.delay * tick, brake), SLOWEST * v_max))
