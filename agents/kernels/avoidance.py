"""Bodies in sight, and the last filter on a command against them (docs/theory.md, section 17)."""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.jit import (
    MATRIX,
    MATRIX_OUT,
    NOTHING,
    REAL,
    VECTOR,
    VECTOR_OUT,
    WHOLE,
    WHOLE_MATRIX_OUT,
    WHOLE_VECTOR_OUT,
    kernel,
    kernel_for,
    named,
)
from agents.kernels.unicycle import step, wrap
from formation.arrays import FloatArray, IntArray

PAST = 128
"""Ticks of own poses that are kept: a sighting may come this late."""
ASIDE = 0.1
"""A body whose bearing is within this of straight ahead is passed on its left side, as by everybody [rad]."""
RETREAT = 0.05
"""Fastest that a robot backs off from a body that is too close [m/s]."""
BLEND, SURPRISE, RESTART = 0.25, 1.9, 8
"""Weight of an innovation in its mean, the mean that is no chance (5 sigma), and sightings that are not forgotten."""
NOT_YET, PATIENCE = 1.5, 2.0
"""A robot that is kept off begins to go round after the one, and does nothing else from the other on [s]."""
BLOCKED = 0.3
"""Share of a command that has to be cut for that."""
SOON = 0.05
"""Time in which the wheels shall have the speed that is wanted [s]."""
MOVING = 0.02
"""A body that moves is passed behind [m/s]."""
ROOM, ROOM_TIME = 0.005, 0.2
"""What is kept beyond the margin on the way round [m], and how fast it is restored [s]."""
TURN = 3.0
"""Turn rate by heading error on the way round [1/s]."""


class Tracks(NamedTuple):
    """Bodies in a frame that is carried along by odometry."""

    own: FloatArray
    """(PAST, 3) own poses, by tick, row k % PAST [m, m, rad]."""
    tick: IntArray
    """(1,) of the newest of them."""
    body: FloatArray
    """(n, 6) x, y and their velocities, when it was last seen [m, m/s]; means of the normalised innovations."""
    seen: IntArray
    """(n, 2) the tick of that, and how often it was seen since it was lost; 0: not in sight."""
    blocked: FloatArray
    """(2,) for how long the robot has been kept off [s]; 1 if it goes round clockwise seen from the body, -1, or 0."""


class Law(NamedTuple):
    """What keeps robots apart."""

    reach: FloatArray
    """(n,) own radius and the other's [m]."""
    margin: FloatArray
    """(n,) distance of the bodies that is kept [m]."""
    limits: FloatArray
    """(2,) of |v| and |omega| [m/s, rad/s]."""
    change: FloatArray
    """(2,) of a wheel speed in a tick [m/s, rad/s]."""
    steer: float
    """Turn rate at which a robot that cannot go on turns aside [rad/s]."""
    round: float
    """Speed at which it goes round a body, in the body's frame [m/s]."""
    kept: int
    """Ticks after which a body that is not seen is forgotten."""


TRACKS = named(Tracks, MATRIX_OUT, WHOLE_VECTOR_OUT, MATRIX_OUT, WHOLE_MATRIX_OUT, VECTOR_OUT)
LAW = named(Law, VECTOR_OUT, VECTOR_OUT, VECTOR_OUT, VECTOR_OUT, REAL, REAL, WHOLE)


def start(robots: int) -> Tracks:
    """Nobody in sight."""
    return Tracks(
        np.zeros((PAST, 3)),
        np.zeros(1, dtype=np.int64),
        np.zeros((robots, 6)),
        np.zeros((robots, 2), dtype=np.int64),
        np.zeros(2),
    )


@kernel_for(NOTHING, TRACKS, WHOLE, REAL, REAL, REAL)
def roll(t: Tracks, k: int, v: float, omega: float, dt: float) -> None:
    """It is tick k now; the wheels had these speeds since the last call [m/s, rad/s]."""
    if k - t.tick[0] >= PAST:
        t.tick[0] = k - 1
        t.seen[:, 1] = 0
    for now in range(t.tick[0] + 1, k + 1):
        before = t.own[(now - 1) % PAST]
        x, y, theta = step(before[0], before[1], before[2], v, omega, dt)
        row = t.own[now % PAST]
        row[0], row[1], row[2] = x, y, theta
    t.tick[0] = k


@kernel_for(NOTHING, TRACKS, LAW, WHOLE, MATRIX, REAL, REAL, REAL, REAL)
def see(t: Tracks, law: Law, at: int, places: FloatArray, alpha: float, beta: float, sigma: float, dt: float) -> None:
    """Bodies were at places (m, 3) at tick `at`: row, x and y in the own frame [m].

    An alpha-beta filter: least squares over the first sightings, then with fading memory, down to these gains. Where
    innovations (of standard deviation sigma [m]) keep to one side, it forgets all but the last few sightings.
    """
    if t.tick[0] - at >= PAST:
        return
    own = t.own[at % PAST]
    c, s = math.cos(own[2]), math.sin(own[2])
    for i in range(len(places)):
        j = int(places[i, 0])
        if not 0 <= j < len(t.seen):
            continue
        x, y = own[0] + c * places[i, 1] - s * places[i, 2], own[1] + s * places[i, 1] + c * places[i, 2]
        body, seen = t.body[j], t.seen[j]
        if seen[1] == 0 or at - seen[0] > law.kept:
            body[:] = 0.0
            body[0], body[1] = x, y
            seen[0], seen[1] = at, 1
        elif at > seen[0]:
            h = (at - seen[0]) * dt
            seen[0], seen[1] = at, seen[1] + 1
            n = seen[1]
            a = max(alpha, 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)))
            b = max(beta, 6.0 / (n * (n + 1.0)))
            mx, my = x - body[0] - h * body[2], y - body[1] - h * body[3]
            body[4] += BLEND * (mx / sigma - body[4])
            body[5] += BLEND * (my / sigma - body[5])
            if n > RESTART and math.hypot(body[4], body[5]) > SURPRISE:
                body[4], body[5], seen[1] = 0.0, 0.0, RESTART
            body[0] += h * body[2] + a * mx
            body[1] += h * body[3] + a * my
            body[2] += b / h * mx
            body[3] += b / h * my


@kernel
def allowed(gap: float, react: float, brake: float) -> float:
    """The closing speed from which one stops within gap [m]: s react + s^2 / (2 brake) = gap; below 0 if gap is."""
    if gap <= 0.0:
        return gap / react
    if brake > 1e6:
        return gap / react
    return brake * (math.sqrt(react * react + 2.0 * gap / brake) - react)


@kernel
def between(value: float, low: float, high: float) -> float:
    """Value, held within the bounds."""
    return min(max(value, low), high)


@kernel
def ahead(
    own: FloatArray,
    commands: FloatArray,
    k: int,
    delay: int,
    rate: float,
    law: Law,
    wheels: FloatArray,
    dt: float,
) -> tuple[float, float, float, float]:
    """The own pose, and v of the wheels, where the command of tick k takes effect."""
    x, y, theta = own[0], own[1], own[2]
    v, w = wheels[0], wheels[1]
    length = len(commands)
    for now in range(k, k + delay):
        given = commands[(now - delay) % length]
        v += between(rate * (between(given[0], -law.limits[0], law.limits[0]) - v), -law.change[0], law.change[0])
        w += between(rate * (between(given[1], -law.limits[1], law.limits[1]) - w), -law.change[1], law.change[1])
        x, y, theta = step(x, y, theta, v, w, dt)
    return x, y, theta, v


@kernel_for(WHOLE, TRACKS, LAW, WHOLE, WHOLE, MATRIX, WHOLE, REAL, REAL, VECTOR, REAL, VECTOR_OUT)
def keep_off(
    t: Tracks,
    law: Law,
    row: int,
    k: int,
    commands: FloatArray,
    delay: int,
    lag: float,
    react: float,
    wheels: FloatArray,
    dt: float,
    command: FloatArray,
) -> int:
    """Change a command that brings the robot too close to a body.

    Args:
        t: what is in sight.
        law: what is kept.
        row: of this robot.
        k: now.
        commands: (LENGTH, 2) by the tick they were given, row t % LENGTH [m/s, rad/s].
        delay: ticks from a command to its effect.
        lag: time constant of the wheels [s].
        react: time in which closing speeds fade [s].
        wheels: (2,) their speeds now.
        dt: [s].
        command: (3,), v and omega, changed; result: v of the wheels a tick later [m/s, rad/s].

    Returns:
        Row of the body that it keeps off; -1 if the command stays what it is.
    """
    rate, reach = 1.0, 1.0
    if lag > 1e-6:
        rate, reach = 1.0 - math.exp(-dt / lag), 1.0 - math.exp(-SOON / lag)
    x, y, theta, rolling = ahead(t.own[k % PAST], commands, k, delay, rate, law, wheels, dt)
    c, s = math.cos(theta), math.sin(theta)
    low, high, below, above = -np.inf, np.inf, -1, -1
    brake = min(law.change[0] / dt, law.limits[0] / max(lag, 1e-9))
    for j in range(len(t.seen)):
        seen = t.seen[j]
        if seen[1] < 2 or k - seen[0] > law.kept:
            continue
        body, h = t.body[j], (k + delay - seen[0]) * dt
        px, py = body[0] + h * body[2] - x, body[1] + h * body[3] - y
        d = max(math.hypot(px, py), 1e-6)
        closing = -(px * body[2] + py * body[3]) / d
        total = allowed(d - law.reach[j] - law.margin[j], react, brake)
        mine = total - closing
        if closing > 0.0:
            mine = max(mine, 0.5 * total)
        if mine < 0.0:
            mine = max(mine, -RETREAT) if row > j else 0.0
        along = (px * c + py * s) / d
        if along > 0.05 and mine / along < high:
            high, above = mine / along, j
        elif along < -0.05 and mine / along > low:
            low, below = mine / along, j
    # The command that brings the wheels to a speed soon, however they lag.
    low, high = rolling + (low - rolling) / reach, rolling + (high - rolling) / reach
    wish = command[0]
    if low <= wish <= high:
        t.blocked[0] = max(t.blocked[0] - 0.5 * dt, 0.0)
        if t.blocked[0] == 0.0:
            t.blocked[1] = 0.0
        return -1
    who = above if wish > high else below
    if low > high:
        low = high = 0.5 * (low + high)
        who = above if wish >= 0.0 else below
    new = between(wish, low, high)
    body, h = t.body[who], (k + delay - t.seen[who, 0]) * dt
    px, py = body[0] + h * body[2] - x, body[1] + h * body[3] - y
    d = max(math.hypot(px, py), 1e-6)
    nx, ny = px / d, py / d
    if abs(wish) > abs(new) and abs(wish) > 1e-3:
        sign = 1.0 if wish > 0.0 else -1.0
        cut = min((wish - new) / wish, 1.0)
        if cut > BLOCKED:
            t.blocked[0] = min(t.blocked[0] + dt, PATIENCE)
        if t.blocked[0] > NOT_YET:
            if t.blocked[1] == 0.0:
                speed = math.hypot(body[2], body[3])
                across = ny * body[2] - nx * body[3]  # its motion along the way round to the right
                wanted = sign * (ny * c - nx * s)
                if speed > MOVING and abs(across) > 0.3 * speed:
                    t.blocked[1] = 1.0 if across < 0.0 else -1.0
                else:
                    t.blocked[1] = 1.0 if wanted > -ASIDE else -1.0
            turn = t.blocked[1]
            back = min((d - law.reach[who] - law.margin[who] - ROOM) / ROOM_TIME, 0.0)
            wx = body[2] + law.round * turn * ny + back * nx
            wy = body[3] - law.round * turn * nx + back * ny
            error = wrap(math.atan2(wy, wx) - theta)
            share = between((t.blocked[0] - NOT_YET) / (PATIENCE - NOT_YET), 0.0, 1.0)
            drive = math.hypot(wx, wy) * max(math.cos(error), 0.0)
            new += share * (between(drive, low, high) - new)
            command[1] += share * (between(TURN * error, -law.steer, law.steer) - command[1])
    command[0] = between(new, -law.limits[0], law.limits[0])
    command[2] = rolling + between(rate * (command[0] - rolling), -law.change[0], law.change[0])
    return who
