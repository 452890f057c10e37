"""How the processes of this room wait for a router of ROS 2 that is not there, or not there yet."""

import logging
from collections.abc import Iterator

from formation.errors import EchelonError
from network.bus import Bus
from network.lifetime import Lifetime
from ros.session import RosSession

AGAIN_SECONDS = 1.0
"""Between two attempts to reach what is not there [s]."""


def sessions(bus: Bus, endpoint: str, node: str, domain: int, lifetime: Lifetime) -> Iterator[RosSession]:
    """A session on their router, and another one when the last was left, until the lifetime is over."""
    told = ""
    while not lifetime.over:
        try:
            session = RosSession(endpoint, node, domain=domain)
        except EchelonError as error:
            told = tell_once(error, told)
            bus.arrivals(AGAIN_SECONDS)
            continue
        with session:
            yield session


def tell_once(error: EchelonError, before: str) -> str:
    """Log what is wrong, once: it may stay so for long. Returns its text, for the next call."""
    if str(error) != before:
        logging.getLogger("echelon").warning("%s", error)
    return str(error)
