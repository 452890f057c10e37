"""Requests from a command to the world of a live run."""

import contextlib

from formation.errors import EchelonError, WireError
from network import topics
from network.bus import Bus, Sample
from network.codec import decode
from network.control import Operation
from network.messages import State
from network.requests import Reply

ANSWER_SECONDS = 3.0


def ask(session: Bus, operation: Operation) -> Reply:
    """Send an operation to the world.

    Raises:
        EchelonError: the world does not answer, or refuses with a reason.
    """
    reply = session.ask(operation, timeout=ANSWER_SECONDS)
    if reply is None:
        raise EchelonError(f"expected the world of run {session.run} to answer; it does not (echelon status)")
    if not reply.ok:
        raise EchelonError(reply.reason)
    return reply


def newest_state(session: Bus) -> State:
    """The newest State of the world.

    Raises:
        EchelonError: it publishes none.
    """
    session.subscribe(topics.state(session.run))
    for item in session.incoming(ANSWER_SECONDS):
        if isinstance(item, Sample) and topics.topic_of(item.key) is topics.STATE:
            with contextlib.suppress(WireError):  # not a valid message
                return decode(State, item.payload)
    raise EchelonError(f"expected the world of run {session.run} to publish its state; it is silent")
