"""The window filter's state and constants (docs/theory.md, section 12): W joint blocks (x, y, theta, d_v, d_l, d_w)."""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.jit import (
    FLAG,
    MATRIX_OUT,
    REAL,
    TABLE_OUT,
    WHOLE,
    WHOLE_MATRIX_OUT,
    WHOLE_VECTOR_OUT,
    kernel,
    named,
)
from formation.arrays import FloatArray, IntArray
from formation.bodies.nominal import Nominal

LENGTH = 1024
"""Ticks of history that are kept."""
X, Y, THETA, DV, DL, DW = range(6)
HEARD, SIGHT = 0, 1
"""Modes of the neighbours' blocks: fed by plans; seen, but never heard."""


class Core(NamedTuple):
    """What the filter is at one stamp; copying the arrays copies it."""

    tick: IntArray
    """(1,) its stamp."""
    mean: FloatArray
    """(W, 6) [m, m, rad, m/s, m/s, rad/s]."""
    cov: FloatArray
    """(6 W, 6 W)."""
    ewma: FloatArray
    """(W, 5) of normalised innovations: forward, lateral, heading, and forward and lateral of relative sensing."""
    rejected: IntArray
    """(W, 2) rejections in a row: localisation, relative."""


class Window(NamedTuple):
    """The whole estimator of one robot, one typed value."""

    base_tick: IntArray
    base_mean: FloatArray
    base_cov: FloatArray
    base_ewma: FloatArray
    base_rejected: IntArray
    """The base: every measurement before its stamp has gone into it."""
    copy_tick: IntArray
    copy_mean: FloatArray
    copy_cov: FloatArray
    copy_ewma: FloatArray
    copy_rejected: IntArray
    """The copy, which stands at the own newest stamp: the estimate."""
    odometry: FloatArray
    """(W, LENGTH, 2) by tick [m/s, rad/s]; row t % LENGTH."""
    until: IntArray
    """(W,) odometry of each block is known before this tick; that of the own one before now."""
    sums: FloatArray
    """(W, 3) integrals of each block's odometry up to `until` [m, rad], and the tick from which on."""
    localised: FloatArray
    """(W, LENGTH, 3) [m, m, rad]."""
    localised_at: IntArray
    """(W, LENGTH) stamp of the row, to tell old rows from new."""
    related: FloatArray
    """(W, LENGTH, 2) the next block's robot in this block's frame [m]."""
    related_at: IntArray
    """(W, LENGTH)."""
    newest: IntArray
    """(1,) newest own stamp, of localisation or relative sensing."""
    alarm: IntArray
    """(1,) stamp of the newest own alarm."""


WINDOW = named(
    Window,
    *(WHOLE_VECTOR_OUT, MATRIX_OUT, MATRIX_OUT, MATRIX_OUT, WHOLE_MATRIX_OUT) * 2,
    *(TABLE_OUT, WHOLE_VECTOR_OUT, MATRIX_OUT, TABLE_OUT, WHOLE_MATRIX_OUT, TABLE_OUT, WHOLE_MATRIX_OUT),
    *(WHOLE_VECTOR_OUT, WHOLE_VECTOR_OUT),
)
"""As compiled code sees it."""


@kernel
def base(w: Window) -> Core:
    """The part that every measurement before its stamp has gone into."""
    return Core(w.base_tick, w.base_mean, w.base_cov, w.base_ewma, w.base_rejected)


@kernel
def estimate(w: Window) -> Core:
    """The part that stands at the own newest stamp: the estimate."""
    return Core(w.copy_tick, w.copy_mean, w.copy_cov, w.copy_ewma, w.copy_rejected)


@kernel
def copy(source: Core, to: Core) -> None:
    """Overwrite a core by another."""
    to.tick[:] = source.tick
    to.mean[:] = source.mean
    to.cov[:] = source.cov
    to.ewma[:] = source.ewma
    to.rejected[:] = source.rejected


def start(slots: FloatArray, sigmas: FloatArray, tick: int = 0) -> Window:
    """A window that begins at a tick.

    Args:
        slots: (W, 3) where the own robot and those upstream are believed to be [m, m, rad].
        sigmas: (W, 2) standard deviations of that, position [m] and heading [rad].
        tick: from which on odometry will be told.
    """
    w = len(slots)
    mean = np.zeros((w, 6))
    mean[:, :3] = slots
    spread = np.concatenate([sigmas[:, [0, 0, 1]], np.tile(DISTURBED, (w, 1))], axis=1)
    core = Core(
        np.full(1, tick, dtype=np.int64),
        mean,
        np.diag(np.square(spread).ravel()),
        np.zeros((w, 5)),
        np.zeros((w, 2), dtype=np.int64),
    )
    none = np.full((w, LENGTH), -1, dtype=np.int64)
    return Window(
        core.tick,
        core.mean,
        core.cov,
        core.ewma,
        core.rejected,
        core.tick.copy(),
        core.mean.copy(),
        core.cov.copy(),
        core.ewma.copy(),
        core.rejected.copy(),
        np.zeros((w, LENGTH, 2)),
        np.full(w, tick, dtype=np.int64),
        np.zeros((w, 3)),
        np.zeros((w, LENGTH, 3)),
        none,
        np.zeros((w, LENGTH, 2)),
        none.copy(),
        np.full(1, tick, dtype=np.int64),
        np.full(1, NO_ALARM, dtype=np.int64),
    )


DISTURBED = (0.001, 0.001, 0.01)
"""Standard deviations of d_v, d_l [m/s] and d_w [rad/s] at the start."""
NO_ALARM = -100_000
"""Stamp of an alarm long ago [ticks]."""


class Tuning(NamedTuple):
    """What the filter is told of the sensors (nominal values), as compiled code takes it."""

    dt: float
    period: int
    """Ticks between localisations."""
    late: int
    """Ticks from a localisation's stamp to its arrival."""
    var_position: float
    var_heading: float
    var_relative: float
    """[m2, rad2, m2]; relative 0: not sensed."""
    gain: float
    """a of the EWMA."""
    threshold: float
    """3.5 sqrt(a / (2 - a))."""
    began: float
    """T_d, how long ago a disturbance that is just detected began [s]."""
    along: float
    along_least: float
    """Q along: (dt (along |w_v| + along_least))^2."""
    gyro: float
    """Q of the heading: (dt gyro)^2 [rad/s]."""
    detects: bool


TUNING = named(Tuning, REAL, WHOLE, WHOLE, *(REAL,) * 9, FLAG)
FINEST = (1e-5, 1e-5)
"""A sensor is taken to be no better than this [m, rad], unless everything is exact."""
LEVELS = (0.01, 0.01, 0.05)
"""Disturbances that are to be found: d_v, d_l [m/s], d_w [rad/s]."""


def tuning(body: Nominal, dt: float, *, sees: bool, detects: bool) -> Tuning:
    """Constants of the filter for these bodies: one rule for all sensors (docs/theory.md, section 12).

    Args:
        body: what may be known of the bodies.
        dt: control interval [s].
        sees: whether relative sensing is used.
        detects: whether disturbances are detected and estimated.
    """
    every = body.period * dt
    position, heading = (0.0, 0.0) if body.exact else (max(body.position, FINEST[0]), max(body.heading, FINEST[1]))
    began = max((position**2 * every / LEVELS[0] ** 2) ** (1.0 / 3.0), dt)
    gain = 1.0 - math.exp(-every / (3.5 * began))
    along, least = (0.1 * body.slip, 0.003) if body.correlated else (body.slip, 0.002)
    return Tuning(
        dt,
        body.period,
        body.age,
        position**2,
        heading**2,
        body.relative**2 + 1e-8 if sees and body.relative is not None else 0.0,
        gain,
        3.5 * math.sqrt(gain / (2.0 - gain)),
        began,
        along,
        least,
        body.gyro,
        detects,
    )
