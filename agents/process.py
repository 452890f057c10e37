"""An agent's process: take what has arrived, feed it to the node, send what the node returns."""

import os
from time import monotonic

from agents.node import AgentNode
from network import topics
from network.bus import Bus, perform
from network.lifetime import Lifetime
from network.throttled_log import ThrottledLog


def join(bus: Bus, robot: int) -> None:
    """Take the place of a robot's agent in the run; the node makes it appear once it is ready."""
    bus.subscribe(topics.tick(bus.run))


def run(bus: Bus, robot: int, lifetime: Lifetime) -> None:
    """Be the agent of a robot until the lifetime is over."""
    join(bus, robot)
    node, log = AgentNode(bus.run, robot, pid=os.getpid()), ThrottledLog()
    perform(bus, node.feed([], monotonic()), log)
    while not lifetime.over:
        perform(bus, node.feed(bus.arrivals(node.patience), monotonic()), log)
