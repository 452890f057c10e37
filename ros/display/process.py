"""The process that shows a run to ROS 2: it listens on the run's bus, and publishes on a session of its own only."""

import json
from collections.abc import Iterable
from time import monotonic, time_ns

from formation.errors import ScenarioError, WireError
from formation.scenario.files import parse
from formation.scenario.registry import register_unloaded
from network import topics
from network.bus import Bus, Kept, Sample
from network.codec import decode
from network.lifetime import Lifetime
from network.messages import Command, State, Status
from network.throttled_log import ThrottledLog
from ros import tokens
from ros.connecting import AGAIN_SECONDS, sessions
from ros.display.node import POSE_SECONDS, DisplayNode
from ros.session import RosPublisher, RosSession
from ros.types import HASHES, NO_HASH

KEPT = 256
"""Commands that wait to be read, at most."""
NODE = "echelon"


def run(bus: Bus, endpoint: str, domain: int, real: Iterable[int], lifetime: Lifetime) -> None:
    """Show the run until the lifetime is over; a router that is not there is waited for."""
    bus.subscribe(topics.state(bus.run))
    bus.subscribe(topics.status(bus.run, "*"))
    commands = bus.keep(topics.command(bus.run, "*"), KEPT)
    bus.appear("display")
    node = DisplayNode(real)
    for session in sessions(bus, endpoint, NODE, domain, lifetime):
        _show(bus, commands, node, _Publishers(session), lifetime)


class _Publishers:
    """One per topic, made when its first message comes."""

    def __init__(self, session: RosSession) -> None:
        self._session = session
        self._found: dict[str, RosPublisher] = {}
        others = [endpoint.hash for token in session.tokens() if (endpoint := tokens.read(token))]
        self._humble = bool(others) and all(one == NO_HASH for one in others)

    def put(self, topic: str, kind: str, data: bytes) -> None:
        if topic not in self._found:
            self._found[topic] = self._session.publisher(topic, kind, NO_HASH if self._humble else HASHES[kind])
        self._found[topic].put(data)


def _show(bus: Bus, commands: Kept, node: DisplayNode, publishers: _Publishers, lifetime: Lifetime) -> None:
    log = ThrottledLog()
    version, asked_at = None, -AGAIN_SECONDS
    while not lifetime.over:
        for item in bus.arrivals(POSE_SECONDS):
            if isinstance(item, Sample):
                _take(node, item, log)
        newest = {sample.key: sample for sample in commands.take()}
        for sample in newest.values():
            _take(node, sample, log)
        if node.version != version and monotonic() - asked_at >= AGAIN_SECONDS:
            asked_at = monotonic()
            version = _learn(bus, node, log)
        for shown in node.show(monotonic(), time_ns()):
            publishers.put(*shown)


def _take(node: DisplayNode, sample: Sample, log: ThrottledLog) -> None:
    kind = sample.key.rsplit("/", 1)[-1]
    try:
        if kind == "state":
            node.take(decode(State, sample.payload))
        else:
            expected: type[Status] | type[Command] = Status if kind == "status" else Command
            found: Status | Command = decode(expected, sample.payload)
            if found.sender == topics.robot_of(sample.key):
                node.take(found)
    except WireError as error:
        log.add(sample.key, str(error))


def _learn(bus: Bus, node: DisplayNode, log: ThrottledLog) -> tuple[int, int] | None:
    """Ask for the scenario; episode and revision of what was learnt, None if nothing was."""
    try:
        setup = bus.setup()
        if setup is None:
            return None
        register_unloaded(setup.user_code)
        node.use(parse(json.loads(setup.scenario), where="the world's scenario"))
    except (WireError, ScenarioError) as error:
        log.add("setup", str(error))
        return None
    return setup.episode, setup.revision
