"""Other bodies in the best response: distances that are kept as a soft cost (docs/theory.md, section 19).

A robot in its place keeps none: the formation is in order, and noise of what it sees shall not move it; if somebody
comes too near, the last filter keeps them apart. The farther it is astray, the farther ahead it looks, the more of the
distance it keeps, and the gentler it drives near others: they have to see it coming.
"""

import math

import numpy as np

from agents.kernels.drifting import between, wrap_small
from agents.kernels.jit import REAL, VECTOR, kernel, kernel_for
from formation.arrays import FloatArray

ROOM = 3.0
"""Weight of a distance, as a share of that of the own slot without trust."""
ORDERLY, ASTRAY = 0.05, 0.15
"""Distance from the own slot up to which a robot is in its place, and from which on it is astray [spacings]."""
COMES = 0.05
"""Speed at which bodies may come nearer in order; at twice that a robot in its place acts as one astray [m/s]."""
AHEAD = 2.0
"""How far ahead it looks when it is astray [s]."""
SHARE = 0.65
"""Part of the distance that it keeps when it is hardly astray."""
HOLD = 0.5
"""A body keeps its velocity for so long, and is taken to stand afterwards [s]."""
ZONE = 0.15
"""A body is near from this gap on, and wholly from half of it on [m]."""
GENTLE, GENTLER = 1e3, 5e3
"""By how much a speed costs more near a body, and within the distance, where the bodies touch."""


@kernel_for(REAL, VECTOR, VECTOR, REAL)
def astray(slot: FloatArray, pose: FloatArray, spacing: float) -> float:
    """0 for a robot in its place, 1 for one that is astray; slot and pose (3,), spacing [m]."""
    away = math.hypot(slot[0] - pose[0], slot[1] - pose[1]) / spacing
    return float(between((away - ORDERLY) / (ASTRAY - ORDERLY), 0.0, 1.0))


@kernel
def met(bodies: FloatArray, pose: FloatArray, v: float) -> float:
    """0 if nobody near comes nearer, 1 if somebody does; pose (3,) and speed v of the robot [m/s]."""
    vx, vy, most = v * math.cos(pose[2]), v * math.sin(pose[2]), 0.0
    for q in range(len(bodies)):
        dx, dy = bodies[q, 0] - pose[0], bodies[q, 1] - pose[1]
        d = max(math.hypot(dx, dy), 1e-9)
        if d < bodies[q, 4] + ZONE:
            most = max(most, ((vx - bodies[q, 2]) * dx + (vy - bodies[q, 3]) * dy) / d)
    return float(between((most - COMES) / COMES, 0.0, 1.0))


@kernel
def courses(bodies: FloatArray, headings: FloatArray, far: float, interval: float) -> FloatArray:
    """Where bodies will be, and the distances to keep from them, see response.Targets.

    Args:
        bodies: (B, BODY) see sight.foresee.
        headings: (N + 1,) of the own slot: whoever moves turns as the formation does [rad].
        far: see astray.
        interval: Delta_T [s].
    """
    ahead = min(len(headings) - 1, round(far * AHEAD / interval))
    share = SHARE + (1.0 - SHARE) * far
    found = np.empty((len(bodies), ahead + 1, 3))
    for q in range(len(bodies)):
        x, y, vx, vy, touch, keep = bodies[q]
        for j in range(ahead + 1):
            found[q, j, 0], found[q, j, 1], found[q, j, 2] = x, y, touch + share * (keep - touch)
            if (j + 0.5) * interval < HOLD:
                turn = wrap_small(headings[j] - headings[0])
                c, s = math.cos(turn), math.sin(turn)
                x, y = x + interval * (c * vx - s * vy), y + interval * (s * vx + c * vy)
    return found


@kernel
def caution(bodies: FloatArray, pose: FloatArray, far: float) -> float:
    """By how much a speed of a robot at this pose (3,) costs more; bodies and far as above."""
    most = 0.0
    for q in range(len(bodies)):
        x, y, _, _, touch, keep = bodies[q]
        gap = math.hypot(x - pose[0], y - pose[1]) - touch
        near = between(2.0 * (1.0 - gap / ZONE), 0.0, 1.0)
        within = between(1.0 - gap / max(keep - touch, 1e-9), 0.0, 1.0)
        most = max(most, GENTLE * near, GENTLER * within)
    return most * far
