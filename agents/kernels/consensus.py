"""The consensus law of one unicycle, compiled, and the plan that follows from it (agents/controllers/consensus.py)."""

import math

from agents.kernels.jit import MATRIX, MATRIX_OUT, NOTHING, REAL, VECTOR, kernel, kernel_for
from agents.kernels.unicycle import step
from formation.arrays import FloatArray


@kernel
def _hand_error(pose: FloatArray, slot: FloatArray, v: float, reach: float) -> tuple[float, float, float]:
    """Error (x, y) of the hand against the slot's, and the signed reach: the hand is on the side the slot moves to."""
    side = reach if v >= 0.0 else -reach
    return (
        pose[0] - slot[0] + side * (math.cos(pose[2]) - math.cos(slot[2])),
        pose[1] - slot[1] + side * (math.sin(pose[2]) - math.sin(slot[2])),
        side,
    )


@kernel_for(NOTHING, VECTOR, VECTOR, MATRIX, VECTOR, VECTOR, MATRIX, MATRIX, REAL, VECTOR, REAL, VECTOR, MATRIX_OUT)
def roll_law(
    pose: FloatArray,
    slot: FloatArray,
    targets: FloatArray,
    other: FloatArray,
    other_slot: FloatArray,
    other_inputs: FloatArray,
    other_targets: FloatArray,
    reach: float,
    gains: FloatArray,
    dt: float,
    limits: FloatArray,
    out: FloatArray,
) -> None:
    """The law's inputs now and, everybody rolled forward, over the horizon.

    Args:
        pose, slot, targets: (3,), (3,), (N, 2) of the robot, its slot, and the slot's inputs.
        other, other_slot, other_inputs, other_targets: the same of its upstream neighbour, and its plan (N, 2).
        reach: of the hand, L [m].
        gains: (2,) k_g to the own slot, k_f to the neighbour [1/s].
        dt: Delta_T [s].
        limits: (2,) of |v| and |omega|; beyond them the hand's velocity keeps its direction.
        out: (N, 2).
    """
    here, there = pose.copy(), other.copy()
    mine, its = slot.copy(), other_slot.copy()
    for j in range(len(out)):
        ex, ey, side = _hand_error(here, mine, targets[j, 0], reach)
        fx, fy, _ = _hand_error(there, its, other_targets[j, 0], reach)
        c, s = math.cos(mine[2]), math.sin(mine[2])
        wx = targets[j, 0] * c - side * targets[j, 1] * s - gains[0] * ex - gains[1] * (ex - fx)
        wy = targets[j, 0] * s + side * targets[j, 1] * c - gains[0] * ey - gains[1] * (ey - fy)
        c, s = math.cos(here[2]), math.sin(here[2])
        v, omega = c * wx + s * wy, (c * wy - s * wx) / side
        over = max(1.0, abs(v) / limits[0], abs(omega) / limits[1])
        out[j, 0], out[j, 1] = v / over, omega / over
        here[0], here[1], here[2] = step(here[0], here[1], here[2], out[j, 0], out[j, 1], dt)
        there[0], there[1], there[2] = step(there[0], there[1], there[2], other_inputs[j, 0], other_inputs[j, 1], dt)
        mine[0], mine[1], mine[2] = step(mine[0], mine[1], mine[2], targets[j, 0], targets[j, 1], dt)
        its[0], its[1], its[2] = step(its[0], its[1], its[2], other_targets[j, 0], other_targets[j, 1], dt)
