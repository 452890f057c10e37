"""The process of a real robot's body: connect to its router, find its topics, then commands out and poses in.

Whatever ends, the robot is told to stand: the process, the run, the link to either.
"""

from queue import Empty
from time import monotonic, sleep, time_ns

import numpy as np

from formation.errors import EchelonError, WireError
from network import topics
from network.bodies import BodyInput
from network.bus import Bus, Sample
from network.codec import decode
from network.inbox import Inbox
from network.lifetime import Lifetime
from network.throttled_log import ThrottledLog
from records.messages import twist, twist_stamped
from ros.body.node import STILL, BodyNode
from ros.connecting import AGAIN_SECONDS, sessions, tell_once
from ros.session import RosPublisher, RosSession
from ros.spec import RobotSpec
from ros.survey import Chosen, choose, robots_of
from ros.types import TWIST

WAIT_SECONDS = 0.01
"""Longest wait for what the world says [s]."""
LOST_SECONDS = 0.5
"""Without a pose for so long its topics are looked for again: it may have come back as another one [s]."""
LAST_ZEROS, LAST_PAUSE = 3, 0.02
"""How often the robot is told to stand at the end, and in between [s]."""


class _Robot:
    """A robot whose topics have been found."""

    def __init__(self, session: RosSession, chosen: Chosen, spec: RobotSpec) -> None:
        self.chosen = chosen
        self.inbox: Inbox[tuple[bytes, float]] = Inbox()
        self._end = session.subscribe(chosen.pose, lambda data, at: self.inbox.put((data, at)))
        self._stamped = chosen.command.type != TWIST
        self._frame = f"{spec.namespace.strip('/')}/base_link".lstrip("/")
        command = chosen.command
        self._publisher: RosPublisher = session.publisher(command.topic, command.type, command.hash)

    def command(self, wanted: tuple[float, float]) -> None:
        """Tell it what to do [m/s, rad/s]."""
        velocity = np.array(wanted)
        self._publisher.put(twist_stamped(time_ns(), self._frame, velocity) if self._stamped else twist(velocity))

    def newest(self) -> tuple[bytes, float] | None:
        """Its newest message since the last look, and when it came in; None if there is none."""
        found = None
        while True:
            try:
                found = self.inbox.get_nowait()
            except Empty:
                return found

    def stand(self) -> None:
        """Tell it to stand, until it must have heard."""
        for _ in range(LAST_ZEROS):
            self.command(STILL)
            sleep(LAST_PAUSE)

    def leave(self) -> None:
        """Its topics are no longer these."""
        self._end()


def run(bus: Bus, spec: RobotSpec, lifetime: Lifetime) -> None:
    """Drive the robot until the lifetime is over; a robot or a router that is not there is waited for."""
    bus.subscribe(topics.body_input(bus.run, spec.number))
    bus.announce(topics.body_pose(bus.run, spec.number))
    bus.appear("body", spec.number)
    for session in sessions(bus, spec.endpoint, f"echelon_{spec.number}", spec.domain, lifetime):
        _drive(bus, session, spec, lifetime)


def _drive(bus: Bus, session: RosSession, spec: RobotSpec, lifetime: Lifetime) -> None:
    node, robot, log, told = BodyNode(spec), None, ThrottledLog(), ""
    looked_at = seen_at = -np.inf
    try:
        while not lifetime.over:
            now = monotonic()
            if now - seen_at > LOST_SECONDS and now - looked_at > AGAIN_SECONDS:
                looked_at = now
                try:
                    robot = _found(session, spec, robot)
                    node.begin(robot.chosen.pose.type)
                except EchelonError as error:
                    told = tell_once(error, told)
            _hear(bus, node, log)
            if robot is None:
                continue
            message = robot.newest()
            if message is not None:
                located = node.locate(*message, monotonic())
                if located is not None:
                    seen_at = message[1]
                    bus.publish(topics.body_pose(bus.run, spec.number), located)
            command = node.command(monotonic())
            if command is not None:
                robot.command(command)
    finally:
        if robot is not None:
            robot.stand()


def _hear(bus: Bus, node: BodyNode, log: ThrottledLog) -> None:
    for item in bus.arrivals(WAIT_SECONDS):
        if isinstance(item, Sample):
            try:
                node.hear(decode(BodyInput, item.payload), monotonic())
            except WireError as error:
                log.add(item.key, str(error))


def _found(session: RosSession, spec: RobotSpec, before: _Robot | None) -> _Robot:
    """The robot as it stands there now, the same as before if nothing has changed. Raises EchelonError: it is not."""
    chosen = choose(spec, robots_of(session.tokens()))
    if before is not None and _same(before.chosen, chosen):
        return before
    if before is not None:
        before.leave()
    return _Robot(session, chosen, spec)


def _same(one: Chosen, other: Chosen) -> bool:
    return one.command.key == other.command.key and one.pose.any_hash == other.pose.any_hash
