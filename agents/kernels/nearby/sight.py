"""Bodies in sight: where they are and how fast, in a frame that odometry carries (docs/theory.md, section 19).

Where the wheels slip, the frame slides: what stands then moves in it by minus the slip, which the estimator knows.
"""

import math

from agents.kernels.drifting import between
from agents.kernels.jit import MATRIX, MATRIX_OUT, NOTHING, REAL, VECTOR, VECTOR_OUT, WHOLE, entry_for, kernel
from agents.kernels.unicycle import step
from formation.arrays import FloatArray

PAST = 128
"""Ticks of own poses that are kept: a sighting may come this late."""
X, Y, VX, VY, EX, EY, SEEN, COUNT, COLUMNS = range(9)
"""Columns of a body: where it was last seen and its velocity, in a frame that odometry carries [m, m/s]; means of the
normalised innovations; the tick at which it was seen; and how often since it was lost, 0: not in sight. COLUMNS is
their number."""
NEWEST, BLOCKED, SIDE, SPEED, FREE, WHO, FAR, MEMORY = range(8)
"""Of the memory: the newest tick; for how long the robot has been kept off [s]; 1 if it goes round a body on the right,
seen from the robot, -1 on the left, 0 if it does not; own v [m/s]; for how long no command had to be changed [s];
the row of the body that was kept off last; how far it is astray (separation.astray). MEMORY is their number."""
V_MAX, OMEGA_MAX, DV, DOMEGA, STEER, ROUND, KEPT, ALPHA, BETA, SIGMA, DT = range(11)
"""Of the law: limits of |v| and |omega|, largest changes of wheel speeds in a tick, turn rate and speed on the way
round a body, ticks after which a body that is not seen is forgotten, gains and standard deviation of sightings [m], the
tick [s]."""
BLEND, SURPRISE, RESTART, BEGIN = 0.25, 1.9, 8, 25
"""Weight of an innovation in its mean, the mean that is no chance (5 sigma), sightings that are not forgotten then, and
for how many it counts that a body that comes into sight moves as the robot does."""
NEAR = 0.5
"""Bodies that are farther away than this concern no plan [m]."""
DISTANCE, SPREAD = 0.03, 0.01
"""What a plan keeps from a body [m], and by how much more with the age of its sighting [m/s]."""
BODY = 6
"""Columns of a body near by, see `foresee`."""


@kernel
def rate_of(time: float, dt: float) -> float:
    """Share of a gap that fades within a tick, with this time constant [s]."""
    return 1.0 - math.exp(-dt / time) if time > 1e-6 else 1.0


@entry_for(NOTHING, MATRIX_OUT, MATRIX_OUT, VECTOR_OUT, VECTOR, WHOLE, REAL, REAL)
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


@entry_for(NOTHING, MATRIX_OUT, MATRIX_OUT, VECTOR_OUT, VECTOR, WHOLE, MATRIX)
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
def ahead(
    own: FloatArray,
    law: FloatArray,
    k: int,
    commands: FloatArray,
    delay: int,
    lag: float,
    wheels: FloatArray,
    slip: float,
) -> tuple[float, float, float, float]:
    """The own pose, and v of the wheels, where the command of tick k takes effect.

    Args:
        own: (3,) pose at tick k.
        law: see above.
        k: now.
        commands: (LENGTH, 2) by the tick they were given, row t % LENGTH [m/s, rad/s].
        delay: ticks from a command to its effect.
        lag: time constant of the wheels [s].
        wheels: (2,) their speeds now.
        slip: speed of the robot beyond that of its wheels [m/s].
    """
    x, y, theta, v, w = own[0], own[1], own[2], wheels[0], wheels[1]
    length, rate = len(commands), rate_of(lag, law[DT])
    for now in range(k, k + delay):
        given = commands[(now - delay) % length]
        v += between(rate * (between(given[0], -law[V_MAX], law[V_MAX]) - v), -law[DV], law[DV])
        w += between(rate * (between(given[1], -law[OMEGA_MAX], law[OMEGA_MAX]) - w), -law[DOMEGA], law[DOMEGA])
        x, y, theta = step(x, y, theta, v + slip, w, law[DT])
    return x, y, theta, v


@kernel
def toward(
    body: FloatArray, at: float, dt: float, x: float, y: float, sx: float, sy: float
) -> tuple[float, float, float]:
    """Distance [m] and direction of a body from (x, y), at tick `at`; (sx, sy) is the own slip in the frame [m/s]."""
    h = (at - body[SEEN]) * dt
    px, py = body[X] + h * (body[VX] + sx) - x, body[Y] + h * (body[VY] + sy) - y
    d = max(math.hypot(px, py), 1e-6)
    return d, px / d, py / d


@kernel
def seen(body: FloatArray, law: FloatArray, k: int) -> bool:
    """Whether a body is in sight."""
    return bool(body[COUNT] > 0.0 and k - body[SEEN] <= law[KEPT])


@entry_for(WHOLE, *(MATRIX, MATRIX, VECTOR, MATRIX, WHOLE), *(MATRIX, WHOLE, REAL, VECTOR, REAL), *(VECTOR, MATRIX_OUT))
def foresee(
    own: FloatArray,
    bodies: FloatArray,
    law: FloatArray,
    reach: FloatArray,
    k: int,
    commands: FloatArray,
    delay: int,
    lag: float,
    wheels: FloatArray,
    slip: float,
    pose: FloatArray,
    out: FloatArray,
) -> int:
    """The bodies near by where the command of tick k takes effect.

    Args:
        own, bodies, law: see above.
        reach: (n, 3) sum of both radii, distance that is kept, and the most that a plan keeps [m].
        k, commands, delay, lag, wheels, slip: see `ahead`.
        pose: (3,) the own pose there, in the world [m, m, rad].
        out: (B, BODY), result: position [m] and velocity [m/s] in the world, sum of both radii, and the distance of
            the centres that a plan keeps [m].

    Returns:
        How many rows of `out` are used.
    """
    x, y, theta, _ = ahead(own[k % PAST], law, k, commands, delay, lag, wheels, slip)
    sx, sy = slip * math.cos(theta), slip * math.sin(theta)
    c, s = math.cos(pose[2] - theta), math.sin(pose[2] - theta)
    count = 0
    for j in range(len(bodies)):
        body = bodies[j]
        if count == len(out) or not seen(body, law, k):
            continue
        d, nx, ny = toward(body, k + delay, law[DT], x, y, sx, sy)
        if d > reach[j, 0] + NEAR:
            continue
        vx, vy = body[VX] + sx, body[VY] + sy
        age = (k + delay - body[SEEN]) * law[DT]
        row = out[count]
        row[0], row[1] = pose[0] + d * (c * nx - s * ny), pose[1] + d * (s * nx + c * ny)
        row[2], row[3] = c * vx - s * vy, s * vx + c * vy
        row[4], row[5] = reach[j, 0], reach[j, 0] + min(DISTANCE + SPREAD * age, reach[j, 2])
        count += 1
    return count
