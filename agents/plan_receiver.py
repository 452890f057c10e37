"""The plans of one neighbour as they come in: the faulty link that they pass, and what is believed after it."""

from collections.abc import Mapping

from agents.belief import Belief
from formation.errors import WireError
from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from formation.scenario.scenario import Scenario
from network.codec import decode, encode
from network.link import Link, damaged
from network.messages import Plan
from network.values import LinkCounts


class PlanReceiver:
    """The plans of one neighbour: the faulty link that they pass, and what is believed after it."""

    def __init__(self, scenario: Scenario, sender: int, receiver: int) -> None:
        self.sender = sender
        self.belief = Belief()
        self.newest = -1
        """seq of the newest plan that came in physically."""
        self._number = self._missing = 0
        """Of the newest plan; plans between those that came in physically."""
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
            sent = plan.number - self._number
            if sent > 1 and self.newest >= 0:  # before the first nobody knows; one a tick is sent at most
                self._missing += min(sent, plan.seq - self.newest) - 1
            self.newest, self._number = plan.seq, plan.number
            # Bursts are counted in messages, and there is one every plan_every ticks.
            self._link.push(plan.seq // self._every, plan.stamp, plan)

    def pop(self, now: float) -> bool:
        """Take what the link delivers until `now` [s]; whether the newest plan has changed."""
        belief = self.belief
        before = belief.plan
        for arrival in self._link.pop(now):
            plan = arrival.message if arrival.damage is None else _read(arrival.message, arrival.damage)
            if plan is None:
                self._corrupt += 1
            else:
                belief.receive(plan)
        return belief.plan is not before

    def counts(self) -> LinkCounts:
        """What became of the plans sent over this link, those included that the real network lost."""
        counts = self._link.counts
        return LinkCounts(
            sent=counts.sent + self._missing,
            delivered=counts.delivered,
            lost=counts.lost + self._missing,
            late=self.belief.late,
            corrupt=self._corrupt,
            duplicated=counts.duplicated,
            in_flight=counts.in_flight,
        )


def _read(sent: Plan, damage: float) -> Plan | None:
    """The plan that arrived with flipped bytes; None if they cannot be read."""
    try:
        return decode(Plan, damaged(encode(sent), damage))
    except WireError:
        return None
