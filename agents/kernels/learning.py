"""Learning on line how late commands act and how slowly wheels follow (docs/theory.md, section 13).

From own commands and odometry: wheels obey w[t+1] = w[t] + rho (c[t-d] - w[t]), rho = 1 - exp(-dt/tau). For every
candidate d the sums of a least squares fit of rho are kept, forgetting old ticks; the d whose fit leaves least
unexplained is the delay. Where commands do not change nothing can be learnt, and nothing is: then it does not matter
either. A delay that is wrong shakes the robot, and that teaches it within some ticks.
"""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.jit import kernel
from agents.kernels.views import shaped
from agents.kernels.window.state import LENGTH
from formation.arrays import FloatArray

CANDIDATES = 61
"""Delays of 0 .. 60 ticks."""
MEMORY = 1.0
"""Time constant with which old ticks are forgotten [s]."""
FLOOR = (2e-6, 2e-5)
"""Odometry is taken to be no better than this [m/s, rad/s]; motion below it teaches nothing."""
EXPLAINED = 0.1
"""A fit is believed only if it leaves at most this share of the changes of wheel speed unexplained."""
HOLD = 5
"""Ticks for which a candidate must have been the best before it is believed."""
EVIDENCE = 25.0
"""A candidate replaces the delay believed in if that explains the last ticks worse by so many variances."""
SLOWEST = 0.004
"""Least rho: tau of 2.5 s at 100 Hz."""
GUESS = 0.3
"""Fits of rho lean on the rho believed in with this much of an excitation of FLOOR: no division by nothing."""


class Motors(NamedTuple):
    """What a robot knows of its motors: commands given, limits, and what it has learnt."""

    model: FloatArray
    """(4,): delay [ticks] and rho that are believed in; the best candidate, and for how many ticks it was."""
    energy: FloatArray
    """(2,): sum of y y, and of the weights of ticks, where y is a change of wheel speed."""
    limits: FloatArray
    """(2,) of |v| and |omega| [m/s, rad/s]."""
    change: FloatArray
    """(2,) largest change of a wheel speed in a tick [m/s, rad/s]."""
    sums: FloatArray
    """(CANDIDATES, 2): sums over the last ticks of u u and u y, with u = c[t-d] - w."""
    commands: FloatArray
    """(LENGTH, 2) by the tick they were given, row t % LENGTH [m/s, rad/s]."""


_SUMS, COMMANDS = 10, 10 + 2 * CANDIDATES
"""Where sums and commands begin in the flat array."""


def _motors_of(flat: FloatArray) -> Motors:
    """The motors that lie in one array, as views of it: compiled code takes that array."""
    return Motors(
        shaped(flat, 0, (4,)),
        shaped(flat, 4, (2,)),
        shaped(flat, 6, (2,)),
        shaped(flat, 8, (2,)),
        shaped(flat, _SUMS, (CANDIDATES, 2)),
        shaped(flat, COMMANDS, (LENGTH, 2)),
    )


motors_of = kernel(_motors_of)


def view(flat: FloatArray) -> Motors:
    """The motors that lie in one array: views of it, not a copy."""
    return _motors_of(flat)


def start(delay: int, rate: float, limits: FloatArray, change: FloatArray) -> FloatArray:
    """Motors that were never commanded, of this delay [ticks] and rho until more is known; limits as in Motors."""
    flat = np.zeros(COMMANDS + 2 * LENGTH)
    motors = view(flat)
    motors.model[:] = delay, rate, delay, 0.0
    motors.limits[:], motors.change[:] = limits, change
    return flat


@kernel
def _rate(m: Motors, d: int) -> float:
    """rho that fits best with delay d."""
    return float(min(max((m.sums[d, 1] + GUESS * m.model[1]) / (m.sums[d, 0] + GUESS), SLOWEST), 1.0))


@kernel
def _misfit(m: Motors, d: int) -> float:
    """What delay d leaves unexplained of the last changes of wheel speed, in units of FLOOR squared."""
    rho = _rate(m, d)
    return float(m.energy[0] - 2.0 * rho * m.sums[d, 1] + rho * rho * m.sums[d, 0])


@kernel
def learn(m: Motors, t: int, before: FloatArray, after: FloatArray, dt: float) -> bool:
    """Take odometry of tick t.

    Args:
        m: changed.
        t: tick.
        before, after: (2,) wheel speeds of tick t - 1 and t [m/s, rad/s].
        dt: [s].

    Returns:
        Whether the delay or the rho believed in changed.
    """
    limits, change, commands = m.limits, m.change, m.commands
    keep = math.exp(-dt / MEMORY)
    m.energy[0] *= keep
    m.energy[1] = m.energy[1] * keep + 1.0
    for d in range(CANDIDATES):
        for c in range(2):
            m.sums[d, c] *= keep
    for c in range(2):
        y = after[c] - before[c]
        if abs(y) > 0.98 * change[c]:
            continue  # the wheels accelerated as fast as they can, whatever rho
        scale = 1.0 / (FLOOR[c] * FLOOR[c])
        m.energy[0] += scale * y * y
        for d in range(CANDIDATES):
            u = min(max(commands[(t - d) % LENGTH, c], -limits[c]), limits[c]) - before[c]
            m.sums[d, 0] += scale * u * u
            m.sums[d, 1] += scale * u * y
    now = int(m.model[0])
    best, least, rho = now, _misfit(m, now), _rate(m, now)
    for d in range(CANDIDATES):
        cost = _misfit(m, d)
        if cost < least:
            best, least, rho = d, cost, _rate(m, d)
    variance = 1.0 + least / m.energy[1]
    m.model[3] = m.model[3] + 1.0 if best == int(m.model[2]) else 1.0
    m.model[2] = float(best)
    if m.model[3] < HOLD or least > EXPLAINED * m.energy[0]:
        return False
    if best != now and _misfit(m, now) - least > EVIDENCE * variance:
        m.model[0], m.model[1] = float(best), rho
        return True
    if best == now and m.sums[now, 0] > EVIDENCE * variance:
        m.model[1] = _rate(m, now)
        return True
    return False


def tau_of(rho: float, dt: float) -> float:
    """Time constant [s] of wheels that close this share of the gap in a tick."""
    return -dt / math.log(1.0 - rho) if rho < 1.0 - 1e-9 else 0.0
