"""Talking with the world of a live run from a command."""

import contextlib

from formation.errors import EchelonError, WireError
from network import topics
from network.bus import Bus, Sample
from network.codec import decode
from network.control import Operation
from network.messages import Reply, State

ANSWER_SECONDS = 3.0


def ask(session: Bus, operation: Operation) -> Reply:
    """Have the world do something.

    Raises:
        EchelonError: it does not answer, or refuses; the text is its reason.
    """
    reply = session.ask(operation, timeout=ANSWER_SECONDS)
    if reply is None:
        raise EchelonError(f"expected the world of run {session.run} to answer; it does not (echelon status)")
    if not reply.ok:
        raise EchelonError(reply.reason)
    return reply


def newest_state(session: Bus) -> State:
    """What the world says now.

    Raises:
        EchelonError: it says nothing.
    """
    session.subscribe(topics.state(session.run))
    for item in session.incoming(ANSWER_SECONDS):
        if isinstance(item, Sample):
            with contextlib.suppress(WireError):  # somebody else's garbage
                return decode(State, item.payload)
    raise EchelonError(f"expected the world of run {session.run} to say how it is; it is silent")
