"""A run that listens for everybody (--insecure): what it is called, and which of its robots have no agent."""

import contextlib

from formation.errors import EchelonError, WireError
from formation.schema import MAX_ROBOTS
from network import topics
from network.access.robot_numbers import spelled
from network.bus import Sample
from network.codec import decode
from network.messages import State
from network.zenoh_bus import ZenohBus

SECONDS = 5.0
"""Longest wait for the router, and for a State [s]."""


def found_at(endpoint: str, wished: frozenset[int] | None) -> tuple[str, frozenset[int]]:
    """The run's name, and the robots to run agents of.

    Args:
        endpoint: of its router.
        wished: robots; None: all that have no agent.

    Raises:
        EchelonError: nobody is there, or no such robot lacks an agent.
    """
    with ZenohBus(endpoint, "*", insecure=True, patience=SECONDS) as session:
        session.subscribe(topics.state("*"))
        for item in session.incoming(SECONDS):
            if isinstance(item, Sample):
                with contextlib.suppress(WireError):  # not a valid message
                    state = decode(State, item.payload)
                    size = min(len(state.poses), MAX_ROBOTS)
                    free = frozenset(range(1, size + 1)) - set(state.live)
                    if not free or not (wished or free) <= free:
                        raise EchelonError(
                            f"expected robots without an agent; got {spelled(wished or ())} of {spelled(free)}"
                        )
                    return item.key.split("/")[1], wished or free
    raise EchelonError(f"expected a run at {endpoint}; no world publishes its state there")
