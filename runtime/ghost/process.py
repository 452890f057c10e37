"""The ghost's process: take what has arrived, feed it to the node, simulate for a moment, send what comes of it."""

from time import monotonic

from network import topics
from network.bus import Bus, perform
from network.lifetime import Lifetime
from network.throttled_log import ThrottledLog
from runtime.ghost.node import GhostNode

TURN_SECONDS = 0.1
"""Longest time spent on simulating before the newest state is read again [s]."""


def run(bus: Bus, lifetime: Lifetime) -> None:
    """Follow the run until the lifetime is over."""
    states = bus.keep(topics.state(bus.run), 1)  # the newest only: a ghost that is late has no use for others
    bus.announce(topics.ghost(bus.run))
    bus.appear("ghost")
    node, log = GhostNode(bus.run), ThrottledLog()
    while not lifetime.over:
        arrived = bus.arrivals(node.patience)
        perform(bus, node.feed([*states.take(), *arrived], monotonic()), log)
        until = monotonic() + TURN_SECONDS
        while node.behind and not lifetime.over and monotonic() < until:
            perform(bus, node.step(), log)
