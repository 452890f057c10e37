"""Commands on their way to the bodies: the link of each robot, and the watchdog that stops who gets none."""

from collections.abc import Mapping

from formation.errors import WireError
from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from formation.scenario.scenario import Scenario
from network.codec import decode, encode
from network.link import Arrival, Link, damaged
from network.messages import Command
from network.values import Severity

WATCHDOG = 0.2
"""A robot that receives no new command for so long stops [s], as a real base controller makes it."""


class CommandLinks:
    """The newest command that has reached each robot."""

    def __init__(self, scenario: Scenario) -> None:
        robots = range(1, scenario.size + 1)
        self._links: dict[int, Link[Command]] = {i: Link(scenario.seed, LinkId.commands_from(i)) for i in robots}
        self._newest: dict[int, Command] = {}
        self._fresh: dict[int, float] = dict.fromkeys(robots, 0.0)
        self.held: set[int] = set()
        """Robots that the watchdog has stopped."""
        self._reported: set[int] = set()

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the faults of the links from now on; one that is not named is perfect."""
        for link in self._links.values():
            link.fault = faults.get(link.id, PERFECT)

    def take(self, commands: Mapping[int, Command], now: float) -> list[tuple[float, float]]:
        """The commands of this tick enter their links; the inputs (v, omega) that the robots act on now, in order.

        Each acts on the newest command that its link has delivered, or on zeros while the watchdog holds it.
        """
        newest, fresh, acted = self._newest, self._fresh, []
        for robot, link in self._links.items():
            command = commands.get(robot)
            if command is not None and link.transparent:
                newest[robot], fresh[robot] = command, now
                self.held.discard(robot)
                acted.append((command.v, command.omega))
            else:
                acted.append(self._carried(robot, command, now))
        return acted

    def _carried(self, robot: int, command: Command | None, now: float) -> tuple[float, float]:
        """The same of one robot whose command may be late, lost or absent."""
        link = self._links[robot]
        if command is not None:
            link.push(command.seq, command.stamp, command)
        for arrival in link.pop(now):
            arrived = _read(arrival)
            if arrived and (robot not in self._newest or arrived.seq > self._newest[robot].seq):
                self._newest[robot], self._fresh[robot] = arrived, now
        newest = self._newest.get(robot)
        stale = newest is None or now - self._fresh[robot] > WATCHDOG + 1e-9
        if stale != (robot in self.held) and (newest is not None or now > WATCHDOG):
            self.held ^= {robot}
        return (0.0, 0.0) if stale or newest is None else (newest.v, newest.omega)

    def reports(self) -> list[tuple[str, Severity]]:
        """Which robots the watchdog has stopped or released since the last call."""
        if self.held == self._reported:
            return []
        changed, self._reported = sorted(self._reported ^ self.held), set(self.held)
        return [_report(robot, stopped=robot in self.held) for robot in changed]


def _report(robot: int, *, stopped: bool) -> tuple[str, Severity]:
    """A line about a robot that the watchdog has stopped or released, and how bad that is."""
    return (f"robot {robot} stopped: no fresh command", "error") if stopped else (f"robot {robot} moves again", "info")


def _read(arrival: Arrival[Command]) -> Command | None:
    """The command that arrived; None if its bytes were damaged."""
    if arrival.damage is None:
        return arrival.message
    try:
        return decode(Command, damaged(encode(arrival.message), arrival.damage))
    except WireError:
        return None
