"""The estimate of the upstream neighbour: the newest plan that arrived, carried forward to now.

Received plans are time-stamped. `aged` rolls the sender's pose along its plan from the stamp to now and drops the
inputs that have elapsed (docs/theory.md, section 5); late or lost messages then cost little. Past the plan's end, and
before the first plan, the neighbour is assumed to be in its slot.
"""

import numpy as np

from agents.controllers.interface import NeighborEstimate
from agents.kernels.unicycle import age, shift
from formation.arrays import FloatArray
from network.messages import Plan


class Belief:
    """The newest plan of one neighbour. The latest stamp wins; an older plan that arrives later is counted."""

    def __init__(self) -> None:
        self.plan: Plan | None = None
        self.late = 0

    def receive(self, plan: Plan) -> None:
        """Take a plan that arrived."""
        if self.plan is not None and plan.stamp <= self.plan.stamp:
            self.late += 1
        else:
            self.plan = plan

    def seconds_old(self, now: float) -> float:
        """Age of the plan [s]; before the first plan, the time since the start of the episode."""
        return max(0.0, now - self.plan.stamp) if self.plan else now

    def aged(self, now: float, slot: FloatArray, tail: FloatArray) -> NeighborEstimate:
        """The neighbour at time `now`.

        Args:
            now: [s].
            slot: (3,) where it should be now.
            tail: (N, 2) inputs that keep it in its slot, for when its plan has ended.
        """
        plan = self.plan
        if plan is None or plan.inputs.shape != tail.shape:
            return NeighborEstimate(slot, tail, plan)
        elapsed = self.seconds_old(now)
        if elapsed >= len(plan.inputs) * plan.interval:
            return NeighborEstimate(slot, tail, plan)
        pose, inputs = np.empty(3), np.empty_like(tail)
        age(plan.pose, plan.inputs, elapsed, plan.interval, pose)
        shift(plan.inputs, elapsed, plan.interval, tail, inputs)
        return NeighborEstimate(pose, inputs, plan)

    def as_if_fresh(self, slot: FloatArray, tail: FloatArray) -> NeighborEstimate:
        """The neighbour as in its newest plan, whatever the plan's age."""
        plan = self.plan
        if plan is None or plan.inputs.shape != tail.shape:
            return NeighborEstimate(slot, tail, plan)
        return NeighborEstimate(plan.pose, plan.inputs, plan)
