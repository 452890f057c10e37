"""The window filter's state and constants (docs/theory.md, section 12): W joint blocks (x, y, theta, d_v, d_l, d_w)."""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.jit import kernel
from agents.kernels.views import shaped
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
    state: FloatArray
    """(6 W,) the numbers of `mean` in a row."""


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
    base_state: FloatArray
    copy_state: FloatArray
    """(6 W,) the numbers of `base_mean` and of `copy_mean` in a row."""


class FlatWindow(NamedTuple):
    """The whole estimator of one robot as one typed value: `window_of` says what lies where.

    Compiled code takes two arrays: taking the nineteen of a Window apart would cost more than most of what is done.
    """

    real: FloatArray
    whole: IntArray
    """whole[0] is W, the number of blocks."""

    def copy(self) -> "FlatWindow":
        """Another value, equal to this one."""
        return FlatWindow(self.real.copy(), self.whole.copy())


def _window_of(real: FloatArray, whole: IntArray) -> Window:
    """The window that lies in the arrays of a FlatWindow; its arrays are views of them."""
    w = whole[0]
    n = 6 * w
    size = n + n * n + 5 * w
    odometry = 2 * size
    sums = odometry + w * LENGTH * 2
    localised = sums + w * 3
    related = localised + w * LENGTH * 3
    copied = 2 + 2 * w
    until = copied + 1 + 2 * w
    localised_at = until + w
    related_at = localised_at + w * LENGTH
    newest = related_at + w * LENGTH
    return Window(
        shaped(whole, 1, (1,)),
        shaped(real, 0, (w, 6)),
        shaped(real, n, (n, n)),
        shaped(real, n + n * n, (w, 5)),
        shaped(whole, 2, (w, 2)),
        shaped(whole, copied, (1,)),
        shaped(real, size, (w, 6)),
        shaped(real, size + n, (n, n)),
        shaped(real, size + n + n * n, (w, 5)),
        shaped(whole, copied + 1, (w, 2)),
        shaped(real, odometry, (w, LENGTH, 2)),
        shaped(whole, until, (w,)),
        shaped(real, sums, (w, 3)),
        shaped(real, localised, (w, LENGTH, 3)),
        shaped(whole, localised_at, (w, LENGTH)),
        shaped(real, related, (w, LENGTH, 2)),
        shaped(whole, related_at, (w, LENGTH)),
        shaped(whole, newest, (1,)),
        shaped(whole, newest + 1, (1,)),
        shaped(real, 0, (n,)),
        shaped(real, size, (n,)),
    )


window_of = kernel(_window_of)


def _empty(w: int) -> FlatWindow:
    """Room for a window of w blocks."""
    n = 6 * w
    real = np.zeros(2 * (n + n * n + 5 * w) + w * (7 * LENGTH + 3))
    whole = np.zeros(5 + 5 * w + 2 * w * LENGTH, dtype=np.int64)
    whole[0] = w
    return FlatWindow(real, whole)


def view(flat: FlatWindow) -> Window:
    """The window that lies in a flat one: views of it, not a copy."""
    return _window_of(*flat)


@kernel
def base(w: Window) -> Core:
    """The part that every measurement before its stamp has gone into."""
    return Core(w.base_tick, w.base_mean, w.base_cov, w.base_ewma, w.base_rejected, w.base_state)


@kernel
def estimate(w: Window) -> Core:
    """The part that stands at the own newest stamp: the estimate."""
    return Core(w.copy_tick, w.copy_mean, w.copy_cov, w.copy_ewma, w.copy_rejected, w.copy_state)


@kernel
def copy(source: Core, to: Core) -> None:
    """Overwrite a core by another. Loops: numba copies slices by way of a third array."""
    to.tick[0] = source.tick[0]
    for i in range(len(to.state)):
        to.state[i] = source.state[i]
        for j in range(len(to.state)):
            to.cov[i, j] = source.cov[i, j]
    for h in range(len(to.ewma)):
        for c in range(5):
            to.ewma[h, c] = source.ewma[h, c]
        for c in range(2):
            to.rejected[h, c] = source.rejected[h, c]


def start(slots: FloatArray, sigmas: FloatArray, tick: int = 0) -> FlatWindow:
    """A window that begins at a tick.

    Args:
        slots: (W, 3) where the own robot and those upstream are believed to be [m, m, rad].
        sigmas: (W, 2) standard deviations of that, position [m] and heading [rad].
        tick: from which on odometry will be known.
    """
    w = len(slots)
    flat = _empty(w)
    window = view(flat)
    spread = np.concatenate([sigmas[:, [0, 0, 1]], np.tile(DISTURBED, (w, 1))], axis=1)
    for mean, cov in ((window.base_mean, window.base_cov), (window.copy_mean, window.copy_cov)):
        mean[:, :3] = slots
        np.fill_diagonal(cov, np.square(spread).ravel())
    for stamps in (window.base_tick, window.copy_tick, window.until, window.newest):
        stamps[:] = tick
    window.localised_at[:] = window.related_at[:] = -1
    window.alarm[0] = NO_ALARM
    return flat


DISTURBED = (0.001, 0.001, 0.01)
"""Standard deviations of d_v, d_l [m/s] and d_w [rad/s] at the start."""
NO_ALARM = -100_000
"""Stamp of an alarm long ago [ticks]."""


class Tuning(NamedTuple):
    """What the filter knows of the sensors (nominal values); compiled code takes it as an array."""

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


@kernel
def tuning_of(q: FloatArray) -> Tuning:
    """The constants that lie in an array, in their order."""
    period, late = int(q[1]), int(q[2])
    return Tuning(q[0], period, late, q[3], q[4], q[5], q[6], q[7], q[8], q[9], q[10], q[11], q[12] > 0.0)


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
