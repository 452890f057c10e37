"""What whoever keeps agents alive reads of a run: the newest of the world's states."""

import contextlib
from collections.abc import Iterable

from formation.errors import WireError
from network.bus import Incoming, Sample
from network.codec import decode
from network.messages import State


def newest(arrivals: Iterable[Incoming]) -> State | None:
    """The last State among what arrived at a subscriber of states alone; None without a valid one."""
    found: State | None = None
    for item in arrivals:
        if isinstance(item, Sample):
            with contextlib.suppress(WireError):  # not a valid message; agents count it
                found = decode(State, item.payload)
    return found
