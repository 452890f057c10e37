"""The state of one robot's waiting (docs/theory.md, section 15)."""

from typing import NamedTuple

import numpy as np

from agents.kernels.jit import kernel
from agents.kernels.views import shaped
from formation.arrays import FloatArray, IntArray

PAST = 16
"""Poses that are kept."""
NEED, RATE, SHORT, INTEGRAL, LAG, PACE, PEAK, SPEED = range(8)
"""Columns of `real`: n [s], r, short [spacings], I, lag [s], pace, peak of |omega_r| [rad/s], reached speed [m/s]."""
WAITS, UNABLE, PLANNED, AWAY, SINCE, DOUBTED = range(6)
"""Columns of `whole`: 1 while waiting; tick before which the robot is not able; 1 once there is a last plan; tick
before which it counts as carried away; tick at which it began to wait, and at which it doubted
where it is."""


class Wait(NamedTuple):
    """The waiting of one robot."""

    real: FloatArray
    """(8,)"""
    whole: IntArray
    """(6,)"""
    pose: FloatArray
    """(3,) at the stamp of the last plan."""
    velocities: FloatArray
    """(N, 2) of the last plan, as planned [m/s, rad/s]."""
    drift: FloatArray
    """(2,) of the last plan [m/s]."""
    news: FloatArray
    """(n, 3) n [s], r, stamp in ticks (-1: none) of every robot, the own included."""
    past: FloatArray
    """(PAST, 3) poses at the stamps of the last plans, newest first; x is NaN where there is none."""


LONG_AGO = -1000
"""Tick of a doubt that never was."""


class FlatWait(NamedTuple):
    """The waiting of one robot as one typed value: `wait_of` says what lies where. Compiled code takes two arrays."""

    real: FloatArray
    whole: IntArray
    """whole[0] and whole[1] are n, the number of robots, and N."""

    def copy(self) -> "FlatWait":
        """Another value, equal to this one."""
        return FlatWait(self.real.copy(), self.whole.copy())


def _wait_of(real: FloatArray, whole: IntArray) -> Wait:
    """The waiting that lies in the arrays of a FlatWait; its arrays are views of them."""
    robots, steps = whole[0], whole[1]
    a = 13 + 2 * steps
    b = a + 3 * robots
    return Wait(
        shaped(real, 0, (8,)),
        shaped(whole, 2, (6,)),
        shaped(real, 8, (3,)),
        shaped(real, 13, (steps, 2)),
        shaped(real, 11, (2,)),
        shaped(real, a, (robots, 3)),
        shaped(real, b, (PAST, 3)),
    )


wait_of = kernel(_wait_of)


def view(flat: FlatWait) -> Wait:
    """The waiting that lies in a flat one: views of it, not a copy."""
    return _wait_of(*flat)


def start(robots: int, steps: int) -> FlatWait:
    """Nobody waits, of so many robots that plan so many steps."""
    flat = FlatWait(
        np.zeros(13 + 2 * steps + 3 * robots + 3 * PAST), np.array([robots, steps, 0, 0, 0, 0, 0, LONG_AGO])
    )
    wait = view(flat)
    wait.real[PACE] = 1.0
    wait.news[:, 2] = -1.0
    wait.past[:] = np.nan
    return flat
