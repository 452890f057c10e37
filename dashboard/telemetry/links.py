"""Health of the ring's links: the age of the newest plan that arrived over each, and whether the link is lost."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from formation.faults import PERFECT, Fault
from formation.link_ids import DRIVING, LinkId, plan_links
from network.messages import State, Status
from network.topics import STATUS
from network.values import LinkCounts

LOST_SECONDS = 0.5
"""A link whose newest plan is older counts as lost: a quarter of the horizon has passed without a plan [s]."""


@dataclass(frozen=True, slots=True)
class LinkView:
    """One directed link of the ring."""

    id: LinkId
    age: float | None
    """Age of the newest plan that arrived [s]; None before the receiver's first status."""
    fault: Fault
    counts: LinkCounts
    deaf: bool = False
    """Whether the receiver has no agent."""

    @property
    def sender(self) -> int:
        """Robot at its beginning."""
        return self.id.sender

    @property
    def receiver(self) -> int:
        """Robot at its end."""
        return self.id.receiver

    @property
    def cut(self) -> bool:
        """Whether nothing passes."""
        return self.fault.cut

    @property
    def lost(self) -> bool:
        """Whether nothing arrives, or nothing has for LOST_SECONDS."""
        return self.cut or self.deaf or (self.age is not None and self.age > LOST_SECONDS)

    @property
    def level(self) -> float:
        """0 is healthy, 1 is lost."""
        return 1.0 if self.lost else min(1.0, max(0.0, (self.age or 0.0) / LOST_SECONDS))

    @property
    def label(self) -> str:
        """Health in a word, so that it does not depend on colour alone."""
        if self.cut:
            return "CUT"
        if self.age is None and not self.deaf:
            return "..."
        return "LOST" if self.lost else "STALE" if self.level > 0.5 else "OK"

    @property
    def loss(self) -> float:
        """Share of the plans sent that were lost, 0 to 1."""
        return self.counts.lost / self.counts.sent if self.counts.sent else 0.0


def ring_links(state: State, statuses: Mapping[int, Status]) -> list[LinkView]:
    """Every link of the ring, ordered by sender; robots that have left it have none."""
    live = frozenset(state.live)
    return [_link(state, statuses, link, live) for link in plan_links(len(state.poses), away=frozenset(state.away))]


def driver_link(state: State, statuses: Mapping[int, Status]) -> LinkView:
    """The link over which robot 1 hears its driver."""
    status = statuses.get(DRIVING.receiver)
    known = status is not None and status.episode == state.episode
    age = status.way_age if status is not None and known else None
    return LinkView(
        DRIVING, age, state.faults.get(DRIVING, PERFECT), LinkCounts(), deaf=DRIVING.receiver not in state.live
    )


def _link(state: State, statuses: Mapping[int, Status], link: LinkId, live: Collection[int]) -> LinkView:
    status = statuses.get(link.receiver)
    age, counts = None, LinkCounts()
    if status is not None and status.episode == state.episode:
        age, counts = age_now(state, status), status.counts
    fault = state.faults.get(link, PERFECT)
    return LinkView(link, age, fault, counts, deaf=link.receiver not in live)


def age_now(state: State, status: Status) -> float:
    """Age of the newest plan over the link to a robot [s]: as in its status, and longer once it sends none any more."""
    silence = state.stamp - status.stamp
    return status.age + (silence if silence > STATUS.stale * max(1.0, state.pace) else 0.0)


def oldest(links: list[LinkView]) -> float:
    """Age of the oldest plan that a robot has to use [s]."""
    return max((link.age for link in links if link.age is not None), default=0.0)
