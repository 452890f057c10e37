"""What the leader knows of its driver: the newest message over driver->1, and the preview that follows from it.

The link keeps its name if another robot leads in place of robot 1.
"""

from collections.abc import Collection, Mapping

from formation.arrays import FloatArray
from formation.driving.law import REST, Centre, Order
from formation.driving.track import Track
from formation.faults import PERFECT, Fault
from formation.link_ids import DRIVING, LinkId
from formation.paths.driven import Driven
from formation.pattern import leader
from formation.scenario.scenario import Scenario
from network.link import Link
from network.messages import Tick

SILENT = 0.5
"""Without a message for so long, robot 1 lets the formation slow down to a stop [s]."""
NUMBER, TICK, CENTRE, ORDER = 0, 1, slice(2, 9), slice(9, 11)
"""Columns of a message, as in network.fields.Drive."""


class DriverReceiver:
    """The driver's messages to robot 1."""

    def __init__(self, scenario: Scenario) -> None:
        self._law, self._tick = scenario.law, scenario.control_interval
        self._stride, self._horizon = scenario.stride, scenario.controller.horizon
        self._silent = max(1, round(SILENT / self._tick))
        self._link: Link[FloatArray] = Link(scenario.seed, DRIVING)
        self._track: Track | None = None
        self._heard = 0
        """Tick of the newest message."""

    @classmethod
    def of(cls, scenario: Scenario, robot: int, away: Collection[int] = ()) -> "DriverReceiver | None":
        """The receiver of a robot, of whom some are away; None unless it is the one that is driven."""
        leads = robot == leader(away, follows=scenario.path.leader == "next")
        return cls(scenario) if leads and isinstance(scenario.path, Driven) else None

    def reshape(self, k: int, scenario: Scenario) -> None:
        """From tick k on the formation has the offsets of this scenario."""
        self._law = scenario.law
        if self._track is not None:
            self._track.obey(k, self._law)

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the fault of the link from now on; a link that is not named is perfect."""
        self._link.fault = faults.get(self._link.id, PERFECT)

    def receive(self, tick: Tick) -> None:
        """What the driver sends at a tick enters the link; take what comes out of it."""
        for message in tick.drive:
            if message[NUMBER] < 0 or not 0 <= message[TICK] <= tick.seq:
                continue  # not the world's
            self._link.push(int(message[NUMBER]), tick.stamp, message)
        for arrival in self._link.pop(tick.stamp):
            if arrival.damage is None:
                self._hear(arrival.message)

    def _hear(self, message: FloatArray) -> None:
        """The newest message counts; the track that it continues is kept."""
        k, order = int(message[TICK]), Order(*message[ORDER].tolist())
        track = self._track
        if track is not None and k <= self._heard:
            return
        centre = Centre(*message[CENTRE].tolist())
        if track is None or track.orders[-1].order != order or k < track.first or track.at(k) != centre:
            self._track = Track(self._law, k, centre, order)
        self._heard = k

    def preview(self, k: int) -> FloatArray | None:
        """The preview that robot 1 tells from tick k on, as in formation/way.py; None before the first message.

        It goes on with the order that was heard, or slows down to a stop if that is too long ago.
        """
        track = self._track
        if track is None:
            return None
        if self.silent(k) and track.orders[-1].order != REST:
            track.order(k, REST)
        track.forget(k - self._stride)
        return track.preview(k, self._stride, self._horizon)

    def silent(self, k: int) -> bool:
        """Whether the driver has not been heard for too long."""
        return k - self._heard >= self._silent

    def age(self, k: int) -> float:
        """How long ago the newest message was sent at tick k [s]."""
        return max(0, k - self._heard) * self._tick
