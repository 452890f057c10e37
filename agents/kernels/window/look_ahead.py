"""From the estimate to where a plan begins: along odometry, then along commands (docs/theory.md, section 13)."""

import math

from agents.kernels.drifting import between
from agents.kernels.jit import kernel
from agents.kernels.learning import Motors
from agents.kernels.unicycle import step
from agents.kernels.window.filter import Heard, Table, guess, roll_on
from agents.kernels.window.state import DL, DV, DW, LENGTH, Window, estimate
from formation.arrays import FloatArray


@kernel
def drifted(pose: FloatArray, v: float, omega: float, lateral: float, dt: float) -> None:
    """A pose (3,) one tick on, in place, under v, omega and a lateral velocity."""
    middle = pose[2] + 0.5 * dt * omega
    pose[0], pose[1], pose[2] = step(pose[0], pose[1], pose[2], v, omega, dt)
    pose[0] -= dt * lateral * math.sin(middle)
    pose[1] += dt * lateral * math.cos(middle)


@kernel
def look_ahead(
    w: Window,
    motors: Motors,
    k: int,
    delay: int,
    rate: float,
    dt: float,
    pose: FloatArray,
    speed: FloatArray,
    twist: FloatArray,
) -> None:
    """The own pose and wheel speeds where a plan made at tick k begins: at k + d.

    Args:
        w: the estimator.
        motors: commands under way, and the wheels' limits.
        k: now.
        delay: d, ticks from a command to its effect.
        rate: share of the gap that wheels close in a tick, 1 - exp(-dt / lag).
        dt: [s].
        pose: (3,), result.
        speed: (2,) of the wheels now; result: those at k + d.
        twist: (2,), result: mean body velocity on the way; without delay that of now.
    """
    commands, limits, change = motors.commands, motors.limits, motors.change
    roll_on(w, k, pose, dt)
    d = estimate(w).mean[0]
    twist[0], twist[1] = 0.0, 0.0
    for t in range(k, k + delay):
        for c in range(2):
            gap = between(commands[(t - delay) % LENGTH, c], -limits[c], limits[c]) - speed[c]
            speed[c] += between(rate * gap, -change[c], change[c])
        v, omega = speed[0] + d[DV], speed[1] + d[DW]
        twist[0] += v / delay
        twist[1] += omega / delay
        drifted(pose, v, omega, d[DL], dt)
    if delay == 0:
        twist[0], twist[1] = speed[0] + d[DV], speed[1] + d[DW]


@kernel
def neighbour_ahead(w: Window, to: int, table: Table, plan: Heard, dt: float, pose: FloatArray) -> None:
    """Block 1, the upstream neighbour as it is seen, carried on to tick `to`; into pose (3,).

    Along its odometry as heard; beyond, along its plan; with the own estimate of its disturbance.
    """
    core = estimate(w)
    m = core.mean[1]
    pose[0], pose[1], pose[2] = m[0], m[1], m[2]
    for t in range(core.tick[0], to):
        if w.until[1] - LENGTH <= t < w.until[1]:
            v, omega = w.odometry[1, t % LENGTH, 0], w.odometry[1, t % LENGTH, 1]
        else:
            v, omega = guess(1, t, table, plan)
        drifted(pose, v + m[DV], omega + m[DW], m[DL], dt)
