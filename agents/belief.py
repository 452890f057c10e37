"""What a robot knows of a neighbour in the ring: the newest plan that arrived, carried forward to where its own begins.

Received plans are time-stamped. `aged` rolls the sender's pose along its plan and drops the inputs that have elapsed
(docs/theory.md, section 5); late or lost messages then cost little. Past the plan's end, and before the first plan, the
neighbour is believed to be in its slot.
"""

import numpy as np

from agents.controllers.interface import NeighborEstimate
from agents.controllers.task import Task
from agents.kernels.drifting import carry, carry_along
from formation.arrays import FloatArray
from network.messages import Plan
from network.values import tuple_maker

_make_estimate = tuple_maker(NeighborEstimate)


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
        """Since the newest plan was sent [s]; since the start of the episode before the first."""
        plan = self.plan
        if plan is None:
            return now
        return now - plan.stamp if now > plan.stamp else 0.0

    def aged(self, at: float, slot: FloatArray, tail: FloatArray) -> NeighborEstimate:
        """The neighbour at a time.

        Args:
            at: where the own plan begins [s].
            slot: (3,) where it should be then.
            tail: (N, 2) inputs that keep it in its slot, for when its plan has ended.
        """
        plan = self.plan
        if plan is None:
            return NeighborEstimate(slot, tail, plan)
        elapsed, interval, shape = at - plan.begins, plan.interval, tail.shape
        if plan.inputs.shape != shape or elapsed >= shape[0] * interval:
            return NeighborEstimate(slot, tail, plan)
        pose, inputs, drift = np.empty(3), np.empty(shape), plan.drift
        carry(plan.pose, plan.inputs, drift, elapsed, interval, tail, pose, inputs)  # elapsed < 0: it looks further
        return NeighborEstimate(pose, inputs, plan, max(elapsed, 0.0), drift)

    def ahead(self, at: float, k: int, task: Task, column: int) -> NeighborEstimate:
        """The neighbour at a time, as `aged` has it.

        Args:
            at: where the own plan begins [s].
            k: the same in ticks.
            task: the own, in which the neighbour's slot is this column.
            column: 1 upstream, 3 downstream.
        """
        plan = self.plan
        if plan is None:
            return NeighborEstimate(*task.slot(k, column), plan)
        elapsed, interval, steps = at - (plan.stamp + plan.delay), plan.interval, task.horizon
        way, drift = plan.inputs, plan.drift
        if len(way) != steps or elapsed >= steps * interval:
            return NeighborEstimate(*task.slot(k, column), plan)
        (block, row), pose, inputs = task.begin(k), np.empty(3), np.empty((steps, 2))
        table, stride, pace = block.inputs, task.stride, task.pace
        carry_along(plan.pose, way, drift, elapsed, interval, table, row, stride, pace, column, pose, inputs)
        return _make_estimate(pose, inputs, plan, elapsed if elapsed > 0.0 else 0.0, drift)

    def as_if_fresh(self, slot: FloatArray, tail: FloatArray) -> NeighborEstimate:
        """The neighbour as in its newest plan, whatever the plan's age."""
        plan = self.plan
        if plan is None or plan.inputs.shape != tail.shape:
            return NeighborEstimate(slot, tail, plan)
        return NeighborEstimate(plan.pose, plan.inputs, plan, 0.0, plan.drift)
