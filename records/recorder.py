"""What becomes of a run's messages in its record, without a clock: stretches, plans and statuses in, messages out."""

import itertools
import json
import zlib
from dataclasses import dataclass
from typing import Literal

import numpy as np

from formation.arrays import FloatArray
from formation.bodies.spec import Bodies
from formation.link_ids import LinkId
from formation.metrics import pattern_errors, tracking_error, tracking_error_of_some
from formation.scenario.registry import DEFAULT
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import to_text
from formation.unicycle import roll_out
from network.messages import VERSION, WORLD, Status
from network.stretch import Order, Recording, Stretch
from network.values import LinkCounts, Motion
from records import messages, pictures
from records.file import RecordFile

Detail = Literal["default", "full"]
"""Whether a record also holds every pose, and every message of the wire that cannot be computed again."""
EXACT_SECONDS = 1.0
"""Simulated time between exact poses in a record of the default detail [s]."""
STATUS_SECONDS = 0.5
"""Least simulated time between two statuses of a robot in a record, with its plan and belief [s]."""
SLOWER = 2
"""Errors and markers are written with every so many stretches: ten times a second, the poses twenty times."""
FAULT_KEYS = ("latency", "jitter", "loss", "burst", "duplicate", "reorder", "rate", "corrupt", "cut")
"""Of a fault, those that are numbers."""
BETWEEN_EPISODES = 10**9
"""Time on the record's clock between two episodes [ns]."""


@dataclass(slots=True)
class _Episode:
    """The episode that is recorded now."""

    number: int
    robots: int
    interval: float
    """[s]."""
    begins: int
    """Where its t = 0 is on the record's clock [ns]."""
    next: int
    """The first tick that has not been written."""
    radii: FloatArray
    """(n,) of the bodies [m]."""
    again: bool
    """Whether simulating it again gives every message that went over the wire."""
    orders: int = 0
    """That have been written."""
    faulty: frozenset[str] = frozenset()
    """Links that are not perfect."""
    away: frozenset[int] = frozenset()
    """Robots over which the ring is closed."""
    event: int = 0
    """Number of the newest event that has been written."""


class Recorder:
    """Writes what it is given of a run to a file. The record's clock is simulated time from the start's date on."""

    def __init__(self, file: RecordFile, run: str, started: int, *, detail: Detail = "default") -> None:
        """A record without an episode yet.

        Args:
            file: to write to.
            run: name of the run.
            started: now [ns since the epoch].
            detail: what is recorded.
        """
        self._file, self._detail = file, detail
        self._clock = started
        """The latest time in the record."""
        self._episode: _Episode | None = None
        self._now = 0.0
        """Simulated time of the newest poses [s]."""
        self._shown: dict[int, float] = {}
        """By robot, when a status was written last [s]."""
        self._ages: dict[LinkId, float] = {}
        """Of the newest plans, as statuses say [s]."""
        file.note("echelon", {"run": run, "version": str(VERSION), "detail": detail, "started": str(started)})

    @property
    def full(self) -> bool:
        """Whether the record holds everything."""
        return self._detail == "full"

    def stands(self, count: int, seconds: float) -> Recording:
        """How the record stands, for displays; `count` numbers these messages, `seconds` are since it began."""
        number, file = self._episode.number if self._episode else 0, self._file
        return Recording(WORLD, count, self._now, number, str(file.path), file.size, seconds)

    def take(self, stretch: Stretch) -> None:
        """Some ticks of the world. Those of an episode whose beginning was not heard are left out."""
        episode = self._episode
        if stretch.scenario and (episode is None or episode.number != stretch.episode):
            episode = self._begin(stretch)
        if episode is None or episode.number != stretch.episode:
            return
        n = episode.robots
        poses, inputs = stretch.poses.reshape(-1, n, 3), stretch.inputs.reshape(-1, n, 2)
        skipped = max(0, episode.next - stretch.first)
        for order in stretch.orders:
            if order.number >= episode.orders:
                episode.orders = order.number + 1
                data = messages.order(order.number, order.tick, order.kind, json.dumps(order.value, sort_keys=True))
                self._write("/orders", "echelon_msgs/Order", self._time(episode, order.tick), data)
                self._note(episode, order)
        for event in stretch.events:
            if event.number > episode.event:
                episode.event = event.number
                at = episode.begins + round(event.stamp * 1e9)
                self._write("/log", "rcl_interfaces/Log", at, messages.log(at, event.severity, event.kind, event.text))
        for one in stretch.excursions:
            at = episode.begins + round(one.at * 1e9)
            self._write("/excursions", "echelon_msgs/Excursion", at, messages.excursion(at, one))
        if skipped >= len(poses):
            return
        self._now = stretch.stamp
        first = stretch.first + skipped
        episode.next = stretch.first + len(poses)
        self._exact(episode, first, poses[skipped:], inputs[skipped:])
        self._show(episode, stretch, poses[-1], inputs[-1])

    def _begin(self, stretch: Stretch) -> _Episode:
        scenario = json.loads(stretch.scenario)  # not validated: the code of a user's own is not loaded here
        interval = float(scenario.get("control_interval", Scenario.model_fields["control_interval"].default))
        begins = self._clock + (BETWEEN_EPISODES if self._episode is not None else 0)
        if stretch.resumed:  # a segment begins where its first tick is
            begins -= round(stretch.first * interval * 1e9)
        n = len(stretch.slots)
        radii = np.array(Bodies.model_validate(scenario.get("bodies", {})).radii(n))
        again = stretch.mode == "lockstep"
        episode = _Episode(stretch.episode, n, interval, begins, stretch.first, radii, again)
        self._episode, self._clock = episode, max(self._clock, begins)
        self._shown.clear()
        self._ages.clear()
        self._now = stretch.stamp
        controller = str(scenario.get("controller", {}).get("name", DEFAULT))
        values = {"number": str(stretch.episode), "mode": stretch.mode, "begins": str(begins), "controller": controller}
        code = {"user_code": to_text(stretch.user_code), "resumed": json.dumps(stretch.resumed)}
        self._file.note("episode", {**values, **code, "scenario": stretch.scenario})
        return episode

    def _note(self, episode: _Episode, order: Order) -> None:
        """What an order means for the rest of the record."""
        if order.kind == "agents":  # what an agent knows that began in the middle is nowhere else
            episode.again = False
        if order.kind == "ring":
            episode.away = frozenset(order.value["away"])
        if order.kind != "faults":
            return
        at = self._time(episode, order.tick)
        for link in sorted(episode.faulty | order.value.keys()):
            keys = order.value.get(link, {})
            data = messages.fault(at, link, (float(keys.get(key, 0.0)) for key in FAULT_KEYS))
            self._write("/faults", "echelon_msgs/Fault", at, data)
        episode.faulty = frozenset(order.value)

    def _time(self, episode: _Episode, tick: int) -> int:
        return episode.begins + round(tick * episode.interval * 1e9)

    def _write(self, topic: str, kind: str, stamp: int, data: bytes) -> None:
        self._clock = max(self._clock, stamp)
        self._file.write(topic, kind, stamp, data)

    def _exact(self, episode: _Episode, first: int, poses: FloatArray, inputs: FloatArray) -> None:
        """What the episode can be compared with, to the last bit."""
        n, at = episode.robots, self._time(episode, first)
        rows = np.ascontiguousarray(poses, dtype="<f8").reshape(-1, 3)
        sums = [zlib.crc32(row.tobytes()) for row in rows]
        self._write("/checks", "echelon_msgs/Checks", at, messages.checks(first, n, sums))
        if self.full:
            self._write("/ticks", "echelon_msgs/Ticks", at, messages.ticks(first, n, poses, inputs))
            return
        every = max(1, round(EXACT_SECONDS / episode.interval))
        for row in range(-first % every, len(poses), every):
            data = messages.ticks(first + row, n, poses[row], inputs[row])
            self._write("/ticks", "echelon_msgs/Ticks", self._time(episode, first + row), data)

    def _show(self, episode: _Episode, stretch: Stretch, poses: FloatArray, inputs: FloatArray) -> None:
        """What viewers show of the last tick."""
        at = self._time(episode, episode.next - 1)
        slots = stretch.slots
        frames = messages.frames(episode.robots)
        robots, placed = frames[: episode.robots], np.vstack([poses, slots, stretch.centre])
        self._write("/tf", "tf2_msgs/TFMessage", at, messages.transforms(at, frames, placed))
        driven = messages.odometries(at, robots, poses, inputs)
        commanded = messages.twists_stamped(at, robots, inputs)
        for robot, odometry, twist in zip(robots, driven, commanded, strict=True):
            self._write(f"/{robot}/odom", "nav_msgs/Odometry", at, odometry)
            self._write(f"/{robot}/cmd_vel", "geometry_msgs/TwistStamped", at, twist)
        if stretch.seq % SLOWER:
            return
        away = episode.away
        distance, angle = pattern_errors(poses, slots, away)
        if away:
            tracking = float(tracking_error_of_some(poses, slots, away))
            distance[[robot - 1 for robot in away]] = angle[[robot - 1 for robot in away]] = np.nan
        else:
            tracking = float(tracking_error(poses, stretch.centre[:2]))
        self._write("/metrics", "echelon_msgs/Metrics", at, messages.metrics(at, tracking, distance, angle))
        ages, n = self._ages, episode.robots
        ages = {link: age for link, age in ages.items() if link == LinkId.plans_to(link.receiver, n, away)}
        edges = pictures.edges(poses, distance, away)
        drawn = [edges, pictures.ways_to(slots, poses), pictures.links(poses, ages)]
        self._write("/markers", "visualization_msgs/MarkerArray", at, messages.markers(at, drawn))
        clearance, gap = _nearest(poses, episode.radii)
        self._write("/contacts", "echelon_msgs/Contacts", at, messages.contacts(at, clearance, gap))

    def wants_status(self, robot: int) -> bool:
        """Whether a status of a robot that comes in now would be written; decoding one costs more than writing it."""
        return self._episode is not None and self._now - self._shown.get(robot, -np.inf) >= STATUS_SECONDS - 1e-9

    def take_status(self, status: Status) -> None:
        """An agent's status: its plan, what it believes of the robot upstream of it, and its link."""
        episode, number = self._episode, status.sender
        if episode is None or status.episode != episode.number or number > episode.robots:
            return
        self._shown[number] = self._now
        self._ages[status.link] = status.age
        robot, at = f"/robot{number}", episode.begins + round(status.stamp * 1e9)
        plan, believes = status.plan, status.believes
        if plan is not None:
            self._draw(episode, f"{robot}/plan", plan, at)
        if believes is not None:
            self._draw(episode, f"{robot}/belief", believes, at)
        counts, way = _counts(status.counts), (status.way_age, status.lost)
        data = messages.link(at, str(status.link), status.age, counts, status.solve, status.gap, way)
        self._write(f"{robot}/link", "echelon_msgs/Link", at, data)

    def _draw(self, episode: _Episode, topic: str, motion: Motion, at: int) -> None:
        poses = roll_out(motion.pose[None], motion.inputs[None], motion.interval)[0]
        begins = episode.begins + round(motion.begins * 1e9)
        step = round(motion.interval * 1e9)
        stamps = [begins + i * step for i in range(len(poses))]
        self._write(topic, "nav_msgs/Path", at, messages.path(at, poses, stamps))

    def take_wire(self, key: str, payload: bytes) -> None:
        """A message as it went over the wire, at the time of the newest poses; `key` is below the run's name."""
        if self.full and self._episode is not None and not self._episode.again:
            at = self._episode.begins + round(self._now * 1e9)
            self._write(f"/wire/{key}", "echelon_msgs/Wire", at, messages.wire(key, payload))


def _nearest(poses: FloatArray, radii: FloatArray) -> tuple[float, float]:
    """Least distance of two centres, and of two bodies [m]."""
    one, other = np.triu_indices(len(poses), k=1)
    apart = np.hypot(*(poses[one, :2] - poses[other, :2]).T)
    return float(apart.min()), float((apart - radii[one] - radii[other]).min())


def _counts(counts: LinkCounts) -> itertools.chain[int]:
    return itertools.chain((counts.sent, counts.delivered, counts.lost), (counts.late, counts.corrupt))
