"""A record as States and Statuses again: what the page needs of it, moment by moment, in the order of the file.

A record has poses twenty times a second, plans, beliefs and links twice; what has no message of its own stays as it was
last. Damage is passed over, as `echelon recording repair` does it.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np

from formation.arrays import FloatArray
from formation.errors import EchelonError
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.metrics import pattern_errors, tracking_error, tracking_error_of_some, wrapped
from formation.pattern import upstream
from formation.scenario.files import parse
from formation.scenario.registry import register_unloaded
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import UserCode
from network.messages import State, Status
from network.values import Event, LinkCounts, Motion
from records.cdr import Fields
from records.messages import LEVELS
from records.scanning import Message, Note, scan

EVENTS = 40
"""Of a State, the newest."""
FRESH = 0.25
"""An age below this is taken to stay as it was until the next status; beyond, the link is silent and it grows [s]."""
SEVERITIES = {level: name for name, level in LEVELS.items()}
KINDS = get_args(get_type_hints(Event)["kind"])
ROW_NS = 95_000_000
"""Time between two rows, at least [ns]: the page keeps ten a second."""
SMALL = 1e-6
"""A turn that is none [rad]."""
_FRAME_BYTES = 56
"""Translation and rotation: seven float64."""
_FIRST_POSE, _POSE_STRIDE = 44, 72
"""Bytes in a nav_msgs/Path whose frame is "map": before the first pose, and from one to the next."""


class Row(NamedTuple):
    """A moment of a record."""

    state: State
    scenario: Scenario
    statuses: Mapping[int, Status]


@dataclass(slots=True)
class _Known:
    """What an episode's messages have told so far."""

    scenario: Scenario
    number: int
    mode: str
    controller: str
    begins: int
    events: list[Event] = field(default_factory=list)
    faults: dict[LinkId, Fault] = field(default_factory=dict)
    live: list[int] = field(default_factory=list)
    away: list[int] = field(default_factory=list)
    plans: dict[int, Motion] = field(default_factory=dict)
    believes: dict[int, Motion] = field(default_factory=dict)
    statuses: dict[int, tuple[float, Status]] = field(default_factory=dict)
    """When they were written [s]."""
    next: int = 0
    """Time of the next row, at least [ns]."""
    gap: float = 0.0
    """Least distance of two bodies so far [m]."""


def rows(path: Path) -> Iterator[Row]:
    """The moments of a record.

    Raises:
        EchelonError: it cannot be read, or it is no record of a run; a line that says so.
    """
    known: _Known | None = None
    frames = _Frames()
    some = False
    for item in scan(path, _wanted):
        match item:
            case Note("episode", values):
                known = _begin(path, values)
            case Message() if known is not None:
                some = True
                if item.topic != "/tf":
                    _take(known, item)
                elif item.time >= known.next:
                    known.next = item.time + ROW_NS
                    yield _row(known, item, frames)
            case _:
                pass
    if known is None or not some:
        raise EchelonError(f"expected a record of a run; {path} has nothing of one")


def _wanted(topic: str) -> bool:
    return topic in ("/tf", "/log", "/orders", "/contacts") or topic.rsplit("/", 1)[-1] in ("plan", "belief", "link")


def _begin(path: Path, values: dict[str, str]) -> _Known:
    try:
        register_unloaded([UserCode.model_validate(code) for code in json.loads(values.get("user_code", "[]"))])
        scenario = parse(json.loads(values["scenario"]), where=f"the scenario in {path.name}")
        number, begins = int(values["number"]), int(values["begins"])
        mode, controller = values["mode"], values["controller"]
    except (KeyError, ValueError) as error:
        raise EchelonError(f"expected metadata of an episode in {path}; got {error}") from None
    live = list(range(1, scenario.size + 1))
    return _Known(scenario, number, mode, controller, begins, live=live)


def _take(known: _Known, message: Message) -> None:
    fields, stamp = Fields(message.data), (message.time - known.begins) * 1e-9
    match message.topic.rsplit("/", 1)[-1]:
        case "log":
            fields.get("i"), fields.get("I")
            severity, kind, text = SEVERITIES.get(fields.get("B"), "info"), fields.text(), fields.text()
            kind = kind if kind in KINDS else "run"
            number = known.events[-1].number + 1 if known.events else 1
            known.events.append(Event(number, max(stamp, 0.0), kind, text, severity))  # type: ignore[arg-type]
            del known.events[:-EVENTS]
        case "contacts":
            fields.header()
            _, gap = fields.get("d"), fields.get("d")
            known.gap = gap if known.gap == 0.0 else min(known.gap, gap)
        case "orders":
            _, _, kind, value = fields.get("Q"), fields.get("Q"), fields.text(), json.loads(fields.text())
            _order(known, kind, value)
        case "plan" | "belief" as kind:
            path = _path(message.data, known.begins)
            if path is not None:
                _planned(known, int(message.topic.split("/")[1].removeprefix("robot")), kind, *path)
        case "link":
            _link(known, int(message.topic.split("/")[1].removeprefix("robot")), fields, stamp)


def _order(known: _Known, kind: str, value: dict[str, Any]) -> None:
    if kind == "faults":
        known.faults = {LinkId.parse(name): Fault.model_validate(keys) for name, keys in value.items()}
    elif kind == "agents":
        known.live = [int(robot) for robot in value["answered"]]
    elif kind == "ring":
        known.away = [int(robot) for robot in value["away"]]


def _path(data: bytes, begins: int) -> tuple[float, FloatArray] | None:
    """When a nav_msgs/Path begins [s], and its poses (N + 1, 3); None if it is none of ours."""
    fields = Fields(data)
    fields.header()
    count = fields.get("I")
    if count < 2 or len(data) != _FIRST_POSE + _FRAME_BYTES + _POSE_STRIDE * (count - 1):
        return None
    first, _ = fields.header()
    found = np.ndarray((count, 7), "<f8", data, _FIRST_POSE, (_POSE_STRIDE, 8))
    return (first - begins) * 1e-9, np.column_stack([found[:, :2], 2.0 * np.arctan2(found[:, 5], found[:, 6])])


def _planned(known: _Known, robot: int, kind: str, begins: float, poses: FloatArray) -> None:
    interval = known.scenario.controller.prediction_interval
    motions = known.plans if kind == "plan" else known.believes
    motions[robot] = Motion(max(begins, 0.0), poses[0], interval, _inputs(poses, interval))


def _inputs(poses: FloatArray, interval: float) -> FloatArray:
    """(N, 2) v, omega that lead from pose to pose (N + 1, 3) [m/s, rad/s]."""
    turned = wrapped(np.diff(poses[:, 2]))
    moved, half = np.diff(poses[:, :2], axis=0), 0.5 * turned
    middle = poses[:-1, 2] + half
    chord = moved[:, 0] * np.cos(middle) + moved[:, 1] * np.sin(middle)
    small = np.abs(half) < SMALL
    length = chord * np.where(small, 1.0, half / np.where(small, 1.0, np.sin(half)))
    return np.column_stack([length, turned]) / interval


def _link(known: _Known, robot: int, fields: Fields, stamp: float) -> None:
    fields.header()
    fields.text()
    age = fields.get("d")
    sent, delivered, lost, late, corrupt = (fields.get("Q") for _ in range(5))
    solve, gap = fields.get("d"), fields.get("d")
    try:
        way_age, over = fields.get("d"), bool(fields.get("B"))
    except struct.error:  # a record of before these were in it
        way_age, over = 0.0, False
    n = known.scenario.size
    if not 1 <= robot <= n:
        return
    status = Status(
        sender=robot,
        seq=0,
        stamp=max(stamp, 0.0),
        episode=known.number,
        link=LinkId(upstream(robot, n, known.away), robot),
        age=age,
        plan=known.plans.get(robot),
        counts=LinkCounts(sent, delivered, lost, late, corrupt),
        solve=solve,
        missed=0,
        gap=gap,
        rejected=0,
        pid=0,
        way_age=way_age,
        lost=over,
        believes=known.believes.get(robot),
    )
    known.statuses[robot] = stamp, status


class _Frames:
    """Reads tf2_msgs/TFMessages that have the same frames again and again."""

    def __init__(self) -> None:
        self._key: tuple[int, bytes] = (0, b"")
        self._names: list[str] = []
        self._places = np.zeros(0, dtype=np.intp)

    def read(self, data: bytes) -> dict[str, FloatArray]:
        """Poses (3,) by frame [m, m, rad]."""
        if self._key != (len(data), data[4:8]):
            self._learn(data)
        found = np.frombuffer(data, dtype=np.uint8)[self._places].reshape(-1, _FRAME_BYTES).view("<f8")
        headings = 2.0 * np.arctan2(found[:, 5], found[:, 6])
        poses = np.column_stack([found[:, :2], np.arctan2(np.sin(headings), np.cos(headings))])
        return dict(zip(self._names, poses, strict=True))

    def _learn(self, data: bytes) -> None:
        fields, starts = Fields(data), []
        self._names = []
        for _ in range(fields.get("I")):
            fields.header()
            self._names.append(fields.text())
            fields.array("d", 7)
            starts.append(fields.at - _FRAME_BYTES)
        self._places = (np.array(starts, dtype=np.intp)[:, None] + np.arange(_FRAME_BYTES)).ravel()
        self._key = (len(data), data[4:8])


def _row(known: _Known, message: Message, frames: _Frames) -> Row:
    n, stamp = known.scenario.size, max((message.time - known.begins) * 1e-9, 0.0)
    found = frames.read(message.data)
    poses = np.array([found[f"robot{i}"] for i in range(1, n + 1)])
    slots = np.array([found[f"slot{i}"] for i in range(1, n + 1)])
    away = known.away
    distance, angle = pattern_errors(poses, slots, away)
    tracking = tracking_error_of_some(poses, slots, away) if away else tracking_error(poses, found["centre"][:2])
    state = State(
        sender=0,
        seq=0,
        stamp=stamp,
        episode=known.number,
        revision=0,
        scenario=known.scenario.name,
        controller=known.controller,
        mode="realtime" if known.mode == "realtime" else "lockstep",
        status="running",
        waiting_for=[],
        dismissed=[],
        speed=1.0,
        pace=1.0,
        overruns=0,
        rejected=0,
        poses=poses,
        slots=slots,
        centre=found["centre"],
        distance_errors=distance,
        angle_errors=angle,
        tracking_error=float(tracking),
        contacts=0,
        gap=known.gap,
        live=list(known.live),
        stopped=[],
        faults=dict(known.faults),
        events=list(known.events),
        compare="",
        away=away,
    )
    return Row(state, known.scenario, _statuses(known, stamp))


def _statuses(known: _Known, stamp: float) -> dict[int, Status]:
    """The statuses as they would be now: the newest in the record, of those that answer."""
    found = {}
    for robot, (at, status) in known.statuses.items():
        if robot in known.live:
            silent = status.age + stamp - at if status.age > FRESH else status.age
            found[robot] = replace(status, stamp=stamp, age=silent)
    return found
