"""The last filter on a command, against bodies in sight (docs/theory.md, section 19)."""

import math

import numpy as np

from agents.kernels.drifting import between
from agents.kernels.jit import MATRIX, REAL, VECTOR, VECTOR_OUT, WHOLE, entry_for, kernel
from agents.kernels.nearby.sight import (
    BLOCKED,
    DT,
    DV,
    FAR,
    FREE,
    PAST,
    ROUND,
    SIDE,
    STEER,
    V_MAX,
    VX,
    VY,
    WHO,
    ahead,
    rate_of,
    seen,
    toward,
)
from agents.kernels.unicycle import wrap
from formation.arrays import FloatArray
from formation.clear.stopping import ENDLESS, RESPONSE, stopping_speed

ASIDE = 0.1
"""A body whose bearing has no larger sine is straight ahead; everybody passes it on the right."""
RETREAT = 0.05
"""Fastest that a robot backs off from a body that is too close [m/s]."""
NOT_YET, PATIENCE = 1.5, 2.0
"""For how long a robot is kept off before it goes round, and for how long at most that counts [s]."""
CLEAR = 0.3
"""It goes on round the body until its commands have been free for so long [s]."""
CUT = 0.3
"""Share of a command that has to be cut for that."""
SOON = 0.05
"""Time in which the wheels shall have the speed that is wanted [s]."""
MOVING = 0.02
"""A body that moves is passed behind [m/s]."""
ROOM, ROOM_TIME = 0.005, 0.2
"""What is kept beyond the margin on the way round [m], and how fast it is restored [s]."""
TURN = 3.0
"""Turn rate by heading error on the way round [1/s]."""
_allowed = kernel(stopping_speed)


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
    slip: float,
    far: float,
) -> tuple[float, float, int, int]:
    """Least and largest v of the wheels [m/s], and the rows of the bodies behind them."""
    c, s, dt = math.cos(theta), math.sin(theta), law[DT]
    sx, sy = slip * c, slip * s
    react = RESPONSE + delay * dt
    low, high, below, above = -np.inf, np.inf, -1, -1
    for j in range(len(bodies)):
        body = bodies[j]
        if not seen(body, law, k):
            continue
        d, nx, ny = toward(body, k + delay, dt, x, y, sx, sy)
        closing = -(nx * (body[VX] + sx) + ny * (body[VY] + sy))
        gap = d - reach[j, 0] - reach[j, 1]
        total = _allowed(gap, react, brake)
        mine = total - closing
        if closing > 0.0:
            mine = max(mine, 0.5 * total)
        elif far > 0.0 and total > 0.0 and brake < ENDLESS:
            # Who leaves may brake as hard as this robot can; to be slower than it now asks too much.
            behind = _allowed(gap + closing * closing / (2.0 * brake), react, brake)
            mine = min(mine, max(behind, -closing))
        if mine < 0.0:
            mine = max(mine, -RETREAT) if row > j else 0.0
        along = nx * c + ny * s
        if along > 0.05 and mine / along < high:
            high, above = mine / along, j
        elif along < -0.05 and mine / along > low:
            low, below = mine / along, j
    return low - min(slip, 0.0), high - max(slip, 0.0), below, above


@kernel
def _side(body: FloatArray, sign: float, nx: float, ny: float, c: float, s: float) -> float:
    """On which side to pass a body in direction n, heading (c, s): 1 right, -1 left."""
    speed = math.hypot(body[VX], body[VY])
    across = ny * body[VX] - nx * body[VY]  # its motion along the way round on the right
    if speed > MOVING and abs(across) > 0.3 * speed:
        return 1.0 if across < 0.0 else -1.0
    return 1.0 if sign * (ny * c - nx * s) > -ASIDE else -1.0


@entry_for(
    WHOLE,
    *(MATRIX, MATRIX, VECTOR_OUT, MATRIX, VECTOR, WHOLE, WHOLE),
    *(MATRIX, WHOLE, REAL, VECTOR, REAL, VECTOR_OUT),
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
    slip: float,
    command: FloatArray,
) -> int:
    """Change a command that brings the robot too close to a body.

    Args:
        own, bodies, memory, law: see above.
        reach: (n, 3) sum of both radii, and the distance of the bodies that is kept [m].
        row: of this robot.
        k, commands, delay, lag, wheels, slip: see sight.ahead.
        command: (3,), v and omega, changed; result: v of the wheels a tick later [m/s, rad/s].

    Returns:
        Row of the body that it keeps off; -1 if the command stays what it is.
    """
    dt, rate, share = law[DT], rate_of(lag, law[DT]), rate_of(lag, SOON)
    x, y, theta, rolling = ahead(own[k % PAST], law, k, commands, delay, lag, wheels, slip)
    brake = min(law[DV] / dt, law[V_MAX] / max(lag, 1e-9))
    low, high, below, above = _bounds(bodies, reach, law, row, k, delay, brake, x, y, theta, slip, memory[FAR])
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
            body, sx, sy = bodies[who], slip * math.cos(theta), slip * math.sin(theta)
            d, nx, ny = toward(body, k + delay, dt, x, y, sx, sy)
            if memory[SIDE] == 0.0:
                sign = 1.0 if wish > 0.0 else -1.0
                memory[SIDE] = _side(body, sign, nx, ny, math.cos(theta), math.sin(theta))
            back = min((d - reach[who, 0] - reach[who, 1] - ROOM) / ROOM_TIME, 0.0)
            wx = body[VX] + sx + law[ROUND] * memory[SIDE] * ny + back * nx
            wy = body[VY] + sy - law[ROUND] * memory[SIDE] * nx + back * ny
            error = wrap(math.atan2(wy, wx) - theta)
            new = between(math.hypot(wx, wy) * max(math.cos(error), 0.0), low, high)
            command[1] = between(TURN * error, -law[STEER], law[STEER])
    command[0] = between(new, -law[V_MAX], law[V_MAX])
    command[2] = rolling + between(rate * (command[0] - rolling), -law[DV], law[DV])
    return who
