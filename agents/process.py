"""A process of one agent or several: take what has arrived, feed it to the node, send what the node returns."""

import os
from collections.abc import Collection
from time import monotonic

from agents.crew import Crew
from agents.node import AgentNode
from network import topics
from network.bus import Bus, perform
from network.lifetime import Lifetime
from network.throttled_log import ThrottledLog


def join(bus: Bus) -> None:
    """Take the place of robots' agents in the run; the nodes make them appear once they are ready."""
    bus.subscribe(topics.tick(bus.run))


def run(bus: Bus, robots: Collection[int], lifetime: Lifetime) -> None:
    """Be the agents of these robots until the lifetime is over."""
    join(bus)
    pid, log = os.getpid(), ThrottledLog()
    node = Crew(bus.run, robots, pid=pid) if len(robots) > 1 else AgentNode(bus.run, *robots, pid=pid)
    perform(bus, node.feed([], monotonic()), log)
    while not lifetime.over:
        perform(bus, node.feed(bus.arrivals(node.patience, node.enough), monotonic()), log)
