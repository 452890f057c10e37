"""Bodies in sight, and the last filter on a command against them (docs/theory.md, section 19)."""

import math

import numpy as np

from agents.kernels.jit import (
    MATRIX,
    MATRIX_OUT,
    NOTHING,
    REAL,
    VECTOR,
    VECTOR_OUT,
    WHOLE,
    kernel,
    kernel_for,
)
from agents.kernels.unicycle import step, wrap
from formation.arrays import FloatArray

PAST = 128
"""Ticks of own poses that are kept: a sighting may come this late."""
X, Y, VX, VY, EX, EY, SEEN, COUNT = range(8)
"""Columns of a body: where it was last seen and its velocity, in a frame that odometry carries [m, m/s]; means of the
normalised innovations; the tick at which it was seen; and how often since it was lost, 0: not in sight."""
NEWEST, BLOCKED, SIDE, SPEED, FREE, WHO = range(6)
"""Of the memory: the newest tick; for how long the robot has been kept off [s]; 1 if it goes round a body on the right,
seen from the robot, -1 on the left, 0 if it does not; own v [m/s]; for how long no command had to be changed [s];
the row of the body that was kept off last."""
V_MAX, OMEGA_MAX, DV, DOMEGA, STEER, ROUND, KEPT, ALPHA, BETA, SIGMA, DT = range(11)
"""Of the law: limits of |v| and |omega|, largest changes of wheel speeds in a tick, turn rate and speed on the way
round a body, ticks after which a body that is not seen is forgotten, gains and standard deviation of sightings [m], the
tick [s]."""
ASIDE = 0.1
"""A body whose bearing has no larger sine is straight ahead; everybody passes it on the right."""
RETREAT = 0.05
"""Fastest that a robot backs off from a body that is too close [m/s]."""
BLEND, SURPRISE, RESTART, BEGIN = 0.25, 1.9, 8, 25
"""Weight of an innovation in its mean, the mean that is no chance (5 sigma), sightings that are not forgotten then, and
for how many it counts that a body that comes into sight moves as the robot does."""
NOT_YET, PATIENCE = 1.5, 2.0
"""For how long a robot is kept off before it goes round, and for how long at most that counts [s]."""
CLEAR = 0.3
"""It goes on round the body until its commands have been free for so long [s]."""
CUT = 0.3
"""Share of a command that has to be cut for that."""
RESPONSE = 0.1
"""Time in which closing speeds fade, beyond the delay of commands [s]."""
SOON = 0.05
"""Time in which the wheels shall have the speed that is wanted [s]."""
MOVING = 0.02
"""A body that moves is passed behind [m/s]."""
ROOM, ROOM_TIME = 0.005, 0.2
"""What is kept beyond the margin on the way round [m], and how fast it is restored [s]."""
TURN = 3.0
"""Turn rate by heading error on the way round [1/s]."""


@kernel
def between(value: float, low: float, high: float) -> float:
    """Value, held within the bounds."""
    return min(max(value, low), high)


@kernel_for(NOTHING, MATRIX_OUT, MATRIX_OUT, VECTOR_OUT, VECTOR, WHOLE, REAL, REAL)
def roll(
    own: FloatArray, bodies: FloatArray, memory: FloatArray, law: FloatArray, k: int, v: float, omega: float
) -> None:
    """It is tick k now; the wheels had these speeds since the last call [m/s, rad/s]; own poses (PAST, 3) by tick."""
    newest = int(memory[NEWEST])
    if k - newest >= PAST:
        newest = k - 1
        bodies[:, COUNT] = 0.0
    for now in range(newest + 1, k + 1):
        before, row = own[(now - 1) % PAST], own[now % PAST]
        row[0], row[1], row[2] = step(before[0], before[1], before[2], v, omega, law[DT])
    memory[NEWEST], memory[SPEED] = k, v


@kernel_for(NOTHING, MATRIX_OUT, MATRIX_OUT, VECTOR_OUT, VECTOR, WHOLE, MATRIX)
def see(own: FloatArray, bodies: FloatArray, memory: FloatArray, law: FloatArray, at: int, places: FloatArray) -> None:
    """Bodies were at places (n, 2) in the own frame at tick `at` [m]; a row of zeros is not in sight.

    An alpha-beta filter: least squares over the first sightings, before which a body is taken to move as the robot
    does, then with fading memory, down to the law's gains. Where innovations keep to one side, it forgets all but the
    last few.
    """
    if memory[NEWEST] - at >= PAST:
        return
    me = own[at % PAST]
    c, s, dt = math.cos(me[2]), math.sin(me[2]), law[DT]
    for j in range(min(len(places), len(bodies))):
        ahead, left = places[j, 0], places[j, 1]
        if ahead == 0.0 and left == 0.0:
            continue
        x, y = me[0] + c * ahead - s * left, me[1] + s * ahead + c * left
        body = bodies[j]
        if body[COUNT] == 0.0 or at - body[SEEN] > law[KEPT]:
            body[:] = 0.0
            body[X], body[Y], body[VX], body[VY] = x, y, memory[SPEED] * c, memory[SPEED] * s
            body[SEEN], body[COUNT] = at, BEGIN
        elif at > body[SEEN]:
            h = (at - body[SEEN]) * dt
            n = body[COUNT] + 1.0
            a = max(law[ALPHA], 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)))
            b = max(law[BETA], 6.0 / (n * (n + 1.0)))
            mx, my = x - body[X] - h * body[VX], y - body[Y] - h * body[VY]
            body[EX] += BLEND * (mx / law[SIGMA] - body[EX])
            body[EY] += BLEND * (my / law[SIGMA] - body[EY])
            if n > RESTART and math.hypot(body[EX], body[EY]) > SURPRISE:
                body[EX], body[EY], n = 0.0, 0.0, RESTART
            body[X] += h * body[VX] + a * mx
            body[Y] += h * body[VY] + a * my
            body[VX] += b / h * mx
            body[VY] += b / h * my
            body[SEEN], body[COUNT] = at, n


@kernel
def _allowed(gap: float, react: float, brake: float) -> float:
    """The closing speed from which one stops within gap [m]: s react + s^2 / (2 brake) = gap; below 0 if gap is."""
    if gap <= 0.0 or brake > 1e6:
        return gap / react
    return brake * (math.sqrt(react * react + 2.0 * gap / brake) - react)


@kernel
def _ahead(
    own: FloatArray, law: FloatArray, k: int, commands: FloatArray, delay: int, rate: float, v: float, w: float
) -> tuple[float, float, float, float]:
    """The own pose, and v of the wheels, where the command of tick k takes effect; v and w are the wheels' now."""
    x, y, theta = own[0], own[1], own[2]
    length = len(commands)
    for now in range(k, k + delay):
        given = commands[(now - delay) % length]
        v += between(rate * (between(given[0], -law[V_MAX], law[V_MAX]) - v), -law[DV], law[DV])
        w += between(rate * (between(given[1], -law[OMEGA_MAX], law[OMEGA_MAX]) - w), -law[DOMEGA], law[DOMEGA])
        x, y, theta = step(x, y, theta, v, w, law[DT])
    return x, y, theta, v


@kernel
def _toward(bodies: FloatArray, j: int, at: float, dt: float, x: float, y: float) -> tuple[float, float, float]:
    """Distance [m] and direction of body j from (x, y), at tick `at`."""
    body = bodies[j]
    h = (at - body[SEEN]) * dt
    px, py = body[X] + h * body[VX] - x, body[Y] + h * body[VY] - y
    d = max(math.hypot(px, py), 1e-6)
    return d, px / d, py / d


@kernel
def _bounds(
    bodies: FloatArray,
    reach: FloatArray,
    law: FloatArray,
    row: int,
    k: int,
    delay: int,
    brake: float,
    x: float,
    y: float,
    theta: float,
) -> tuple[float, float, int, int]:
    """Least and largest v of the robot [m/s], and the rows of the bodies behind them."""
    c, s, dt = math.cos(theta), math.sin(theta), law[DT]
    react = RESPONSE + delay * dt
    low, high, below, above = -np.inf, np.inf, -1, -1
    for j in range(len(bodies)):
        body = bodies[j]
        if body[COUNT] == 0.0 or k - body[SEEN] > law[KEPT]:
            continue
        d, nx, ny = _toward(bodies, j, k + delay, dt, x, y)
        closing = -(nx * body[VX] + ny * body[VY])
        total = _allowed(d - reach[j, 0] - reach[j, 1], react, brake)
        mine = total - closing
        if closing > 0.0:
            mine = max(mine, 0.5 * total)
        if mine < 0.0:
            mine = max(mine, -RETREAT) if row > j else 0.0
        along = nx * c + ny * s
        if along > 0.05 and mine / along < high:
            high, above = mine / along, j
        elif along < -0.05 and mine / along > low:
            low, below = mine / along, j
    return low, high, below, above


@kernel
def _side(body: FloatArray, sign: float, nx: float, ny: float, c: float, s: float) -> float:
    """On which side to pass a body in direction n, heading (c, s): 1 right, -1 left."""
    speed = math.hypot(body[VX], body[VY])
    across = ny * body[VX] - nx * body[VY]  # its motion along the way round on the right
    if speed > MOVING and abs(across) > 0.3 * speed:
        return 1.0 if across < 0.0 else -1.0
    return 1.0 if sign * (ny * c - nx * s) > -ASIDE else -1.0


@kernel_for(
    WHOLE,
    *(MATRIX, MATRIX, VECTOR_OUT, MATRIX, VECTOR, WHOLE, WHOLE),
    *(MATRIX, WHOLE, REAL, VECTOR, VECTOR_OUT),
)
def keep_off(
    own: FloatArray,
    bodies: FloatArray,
    memory: FloatArray,
    reach: FloatArray,
    law: FloatArray,
    row: int,
    k: int,
    commands: FloatArray,
    delay: int,
    lag: float,
    wheels: FloatArray,
    command: FloatArray,
) -> int:
    """Change a command that brings the robot too close to a body.

    Args:
        own, bodies, memory, law: see above.
        reach: (n, 2) sum of both radii, and the distance of the bodies that is kept [m].
        row: of this robot.
        k: now.
        commands: (LENGTH, 2) by the tick they were given, row t % LENGTH [m/s, rad/s].
        delay: ticks from a command to its effect.
        lag: time constant of the wheels [s].
        wheels: (2,) their speeds now.
        command: (3,), v and omega, changed; result: v of the wheels a tick later [m/s, rad/s].

    Returns:
        Row of the body that it keeps off; -1 if the command stays what it is.
    """
    dt, rate, share = law[DT], 1.0, 1.0
    if lag > 1e-6:
        rate, share = 1.0 - math.exp(-dt / lag), 1.0 - math.exp(-SOON / lag)
    x, y, theta, rolling = _ahead(own[k % PAST], law, k, commands, delay, rate, wheels[0], wheels[1])
    brake = min(law[DV] / dt, law[V_MAX] / max(lag, 1e-9))
    low, high, below, above = _bounds(bodies, reach, law, row, k, delay, brake, x, y, theta)
    # The command that brings the wheels to a speed soon, however they lag.
    low, high = rolling + (low - rolling) / share, rolling + (high - rolling) / share
    wish = command[0]
    free = low <= wish <= high
    if free:
        memory[BLOCKED] = max(memory[BLOCKED] - 0.5 * dt, 0.0)
        memory[FREE] += dt
        if memory[BLOCKED] == 0.0:
            memory[SIDE] = 0.0
        if memory[SIDE] == 0.0 or memory[FREE] > CLEAR:
            return -1
        who = int(memory[WHO])
    else:
        who = above if wish > high else below
        memory[FREE] = 0.0
    if low > high:
        low = high = 0.5 * (low + high)
        who = above if wish >= 0.0 else below
    memory[WHO] = who
    new = between(wish, low, high)
    if free or (abs(wish) > abs(new) and abs(wish) > 1e-3):
        if not free and (wish - new) / wish > CUT:
            memory[BLOCKED] = min(memory[BLOCKED] + dt, PATIENCE)
        if memory[BLOCKED] > NOT_YET or memory[SIDE] != 0.0:
            body = bodies[who]
            d, nx, ny = _toward(bodies, who, k + delay, dt, x, y)
            if memory[SIDE] == 0.0:
                sign = 1.0 if wish > 0.0 else -1.0
                memory[SIDE] = _side(body, sign, nx, ny, math.cos(theta), math.sin(theta))
            back = min((d - reach[who, 0] - reach[who, 1] - ROOM) / ROOM_TIME, 0.0)
            wx = body[VX] + law[ROUND] * memory[SIDE] * ny + back * nx
            wy = body[VY] - law[ROUND] * memory[SIDE] * nx + back * ny
            error = wrap(math.atan2(wy, wx) - theta)
            new = between(math.hypot(wx, wy) * max(math.cos(error), 0.0), low, high)
            command[1] = between(TURN * error, -law[STEER], law[STEER])
    command[0] = between(new, -law[V_MAX], law[V_MAX])
    command[2] = rolling + between(rate * (command[0] - rolling), -law[DV], law[DV])
    return who
