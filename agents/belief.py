"""What a robot knows of a neighbour in the ring: the newest plan that arrived, carried forward to where its own begins.

Received plans are time-stamped. `aged` rolls the sender's pose along its plan and drops the inputs that have elapsed
(docs/theory.md, section 5); late or lost messages then cost little. Past the plan's end, and before the first plan, the
neighbour is believed to be in its slot.
"""

from collections.abc import Mapping

import numpy as np

from agents.controllers.interface import NeighborEstimate
from agents.kernels.motion import age_drifting
from agents.kernels.unicycle import shift
from formation.arrays import FloatArray
from formation.errors import WireError
from formation.faults import PERFECT, Fault
from formation.links import LinkId
from formation.scenario.scenario import Scenario
from network.codec import decode, encode
from network.link import Arrival, Link, damaged
from network.messages import Plan
from network.values import LinkCounts


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
        return max(0.0, now - self.plan.stamp) if self.plan else now

    def aged(self, at: float, slot: FloatArray, tail: FloatArray) -> NeighborEstimate:
        """The neighbour at a time.

        Args:
            at: where the own plan begins [s].
            slot: (3,) where it should be then.
            tail: (N, 2) inputs that keep it in its slot, for when its plan has ended.
        """
        plan = self.plan
        if plan is None or plan.inputs.shape != tail.shape:
            return NeighborEstimate(slot, tail, plan)
        elapsed = at - plan.begins  # negative if the sender looks further ahead
        if elapsed >= len(plan.inputs) * plan.interval:
            return NeighborEstimate(slot, tail, plan)
        pose, inputs = np.empty(3), np.empty_like(tail)
        age_drifting(plan.pose, plan.inputs, plan.drift, elapsed, plan.interval, pose)
        shift(plan.inputs, max(elapsed, 0.0), plan.interval, tail, inputs)
        return NeighborEstimate(pose, inputs, plan, max(elapsed, 0.0), plan.drift)

    def as_if_fresh(self, slot: FloatArray, tail: FloatArray) -> NeighborEstimate:
        """The neighbour as in its newest plan, whatever the plan's age."""
        plan = self.plan
        if plan is None or plan.inputs.shape != tail.shape:
            return NeighborEstimate(slot, tail, plan)
        return NeighborEstimate(plan.pose, plan.inputs, plan, 0.0, plan.drift)


class PlanReceiver:
    """The plans of one neighbour: the faulty link that they pass, and what is believed after it."""

    def __init__(self, scenario: Scenario, sender: int, receiver: int) -> None:
        self.sender = sender
        self.belief = Belief()
        self.newest = -1
        """seq of the newest plan that came in physically."""
        self._every = scenario.controller.plan_every
        self._link: Link[Plan] = Link(scenario.seed, LinkId(sender, receiver), scenario.link)
        self._corrupt = 0

    @property
    def id(self) -> LinkId:
        """The link that they pass."""
        return self._link.id

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the fault of the link from now on; a link that is not named is perfect."""
        self._link.fault = faults.get(self.id, PERFECT)

    def push(self, plan: Plan) -> None:
        """A plan came in physically; one that was there before is ignored."""
        if plan.seq > self.newest:
            self.newest = plan.seq
            # Bursts are counted in messages, and there is one every plan_every ticks.
            self._link.push(plan.seq // self._every, plan.stamp, plan)

    def pop(self, now: float) -> bool:
        """Take what the link delivers until `now` [s]; whether the newest plan has changed."""
        before = self.belief.plan
        for arrival in self._link.pop(now):
            try:
                self.belief.receive(_read(arrival))
            except WireError:
                self._corrupt += 1
        return self.belief.plan is not before

    def counts(self) -> LinkCounts:
        """What became of the plans sent over this link."""
        counts = self._link.counts
        return LinkCounts(
            sent=counts.sent,
            delivered=counts.delivered,
            lost=counts.lost,
            late=self.belief.late,
            corrupt=self._corrupt,
            duplicated=counts.duplicated,
            in_flight=counts.in_flight,
        )


def _read(arrival: Arrival[Plan]) -> Plan:
    """The plan that arrived. Raises WireError if its bytes were damaged."""
    if arrival.damage is None:
        return arrival.message
    return decode(Plan, damaged(encode(arrival.message), arrival.damage))
