"""Health of the ring's links: the age of the newest plan that arrived over each, and whether the link is lost."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from formation.pattern import downstream
from network.messages import LinkCounts, State, Status
from network.topics import STATUS

LOST_SECONDS = 0.5
"""A link whose newest plan is older counts as lost: a quarter of the horizon has passed without a plan [s]."""


@dataclass(frozen=True, slots=True)
class LinkView:
    """One directed link of the ring."""

    sender: int
    receiver: int
    age: float | None
    """Age of the newest plan that arrived [s]; None before the receiver's first status."""
    fault: Mapping[str, Any]
    """Keys of formation.faults.Fault that differ from a perfect link's."""
    counts: LinkCounts
    deaf: bool = False
    """Whether the receiver has no agent."""

    @property
    def name(self) -> str:
        """The link's name in the world: "1->2"."""
        return f"{self.sender}->{self.receiver}"

    @property
    def cut(self) -> bool:
        """Whether nothing passes."""
        return bool(self.fault.get("cut"))

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
    """Every link of the ring, ordered by sender."""
    robots = len(state.poses)
    return [_link(state, statuses, sender, downstream(sender, robots)) for sender in range(1, robots + 1)]


def _link(state: State, statuses: Mapping[int, Status], sender: int, receiver: int) -> LinkView:
    status = statuses.get(receiver)
    age, counts = None, LinkCounts()
    if status is not None and status.episode == state.episode:
        silence = state.stamp - status.stamp
        age = status.age + (silence if silence > STATUS.stale * max(1.0, state.pace) else 0.0)
        counts = status.counts
    fault = state.faults.get(f"{sender}->{receiver}", {})
    return LinkView(sender, receiver, age, fault, counts, deaf=receiver not in state.live)


def oldest(links: list[LinkView]) -> float:
    """Age of the oldest plan that a robot has to use [s]."""
    return max((link.age for link in links if link.age is not None), default=0.0)
