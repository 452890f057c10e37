"""The motion of one wheeled robot, eq. (1), integrated exactly for an input that is held.

World and agents use `step` and `wrap`: the plant calls them as Python, the solver compiles them. They are therefore
written with scalars and the math module only. `roll_out` is the same motion for many robots and inputs at once.
"""

import math

import numpy as np

from formation.arrays import FloatArray

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


def roll_out(poses: FloatArray, inputs: FloatArray, interval: float) -> FloatArray:
    """Poses (n, N + 1, 3) that robots pass when they hold each input for `interval`: `step` after `step`.

    Args:
        poses: (n, 3) at the start [m, m, rad].
        inputs: (n, N, 2) v, omega [m/s, rad/s].
        interval: [s].
    """
    half = 0.5 * interval * inputs[..., 1]
    small = np.abs(half) < SMALL_TURN
    chord = inputs[..., 0] * interval * np.where(small, 1.0 - half**2 / 6.0, np.sin(half) / np.where(small, 1.0, half))
    turned = np.cumsum(2.0 * half, axis=1)
    middle = poses[:, 2:] + turned - half
    moved = np.cumsum(np.stack([chord * np.cos(middle), chord * np.sin(middle), 2.0 * half], axis=-1), axis=1)
    start = poses[:, None, :]
    return np.concatenate([start, start + moved], axis=1)
