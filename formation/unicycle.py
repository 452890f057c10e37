"""The motion of one wheeled robot, eq. (1), integrated exactly for an input that is held.

World and agents use this one function: the plant calls it as Python, the solver compiles it. It is therefore
written with scalars and the math module only.
"""

import math

SMALL_TURN = 1e-4
"""Half turn [rad] below which sin(h)/h is taken from its series; the first term left out is h^4/120 < 1e-18."""


def step(x: float, y: float, theta: float, v: float, omega: float, dt: float) -> tuple[float, float, float]:
    """Pose after holding (v, omega) for dt: an arc of a circle, or a straight line.

    Args:
        x, y, theta: pose [m, m, rad].
        v, omega: input [m/s, rad/s].
        dt: time [s].
    """
    half = 0.5 * omega * dt
    chord = v * dt
    if abs(half) < SMALL_TURN:
        chord *= 1.0 - half * half / 6.0
    else:
        chord *= math.sin(half) / half
    middle = theta + half
    return x + chord * math.cos(middle), y + chord * math.sin(middle), theta + omega * dt


def wrap(angle: float) -> float:
    """The same angle in (-pi, pi] [rad]."""
    return math.atan2(math.sin(angle), math.cos(angle))
