"""The world's process: take what has arrived, feed it to the node, send what the node returns."""

from collections.abc import Callable, Sequence
from itertools import takewhile
from time import monotonic

from network import topics
from network.bus import Bus, perform
from network.lifetime import Lifetime
from network.throttled_log import ThrottledLog
from network.values import Event, Mode
from world.node import WorldNode
from world.parts import Parts
from world.real_robots import RealRobots, between
from world.resume.saver import Saver


def join(bus: Bus, mode: Mode) -> None:
    """Take the world's place in the run."""
    bus.announce(topics.tick(bus.run), reliable=topics.TICK.is_reliable(mode))
    bus.announce(topics.state(bus.run))
    bus.announce(topics.stretch(bus.run), reliable=topics.STRETCH.is_reliable(mode))
    bus.subscribe(topics.command(bus.run, "*"))
    bus.subscribe(topics.status(bus.run, "*"))
    bus.subscribe(topics.recording(bus.run))
    bus.serve(topics.control(bus.run))
    bus.serve(topics.question(bus.run))
    bus.watch()
    bus.appear("world")


def run(
    bus: Bus,
    parts: Parts,
    lifetime: Lifetime,
    saver: Saver | None = None,
    robots: RealRobots | None = None,
    show: Callable[[Event], None] | None = None,
) -> bool:
    """Simulate a world until the lifetime is over, or a user stops it.

    Args:
        bus: of this process.
        parts: of the run, as it begins or goes on.
        lifetime: when to end.
        saver: keeps what another process would go on from; None: the run ends with this process.
        robots: those that are real, if there are any.
        show: called with every event, where nobody else prints them.

    Returns:
        Whether a user stopped it.
    """
    join(bus, parts.world.mode)
    node, log = WorldNode(bus.run, parts), ThrottledLog()
    feed = node.feed if robots is None else between(robots, parts.world, node.feed)
    for key in robots.poses_from if robots else ():
        bus.subscribe(key)
    for key in robots.inputs_to if robots else ():
        bus.announce(key)
    shown = 0
    while not (lifetime.over or node.over):
        actions = feed(bus.arrivals(node.patience(monotonic()), node.enough), monotonic())
        if saver is not None:
            saver.look(parts)
        perform(bus, actions, log)
        if show is not None:
            shown = _show(parts.world.events, shown, show)
    perform(bus, node.close(monotonic()), log)
    return node.over


def _show(events: Sequence[Event], shown: int, show: Callable[[Event], None]) -> int:
    """Show the events after number `shown`, oldest first; the newest one's number."""
    new = [*takewhile(lambda event: event.number > shown, reversed(events))]
    for event in reversed(new):
        show(event)
    return new[0].number if new else shown
