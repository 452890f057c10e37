"""A record as it is read: its episodes, what was ordered in them, and every pose that it holds."""

import json
import math
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.errors import EchelonError
from records.cdr import Fields
from records.scanning import Damage, End, Message, Note, scan


@dataclass(frozen=True, slots=True)
class RecordedOrder:
    """An Order, as network/stretch.py has it."""

    number: int
    tick: int
    kind: str
    value: dict[str, Any]


@dataclass(slots=True)
class RecordedEpisode:
    """What a record holds of an episode."""

    number: int
    mode: str
    controller: str
    begins: int
    """Where its t = 0 is on the record's clock [ns]."""
    scenario: str
    """JSON."""
    user_code: str = "[]"
    """JSON: the code of a user's own that it ran with."""
    resumed: tuple[int, ...] = ()
    """Ticks from which on its world went on from a saved state: at the last of them this segment begins."""
    orders: list[RecordedOrder] = field(default_factory=list)
    checks: dict[int, tuple[int, ...]] = field(default_factory=dict)
    """By tick, the CRC-32 of each robot's pose."""
    poses: dict[int, FloatArray] = field(default_factory=dict)
    """By tick, the exact poses (n, 3), where the record has them."""
    inputs: dict[int, FloatArray] = field(default_factory=dict)
    """By tick, the inputs (n, 2) that led there."""
    shown: dict[tuple[int, int], tuple[float, ...]] = field(default_factory=dict)
    """By time [ns] and robot: x, y, theta, v, omega, as viewers show them."""
    errors: dict[int, tuple[float, FloatArray, FloatArray]] = field(default_factory=dict)
    """By time [ns]: tracking error [m], l_e (n,) [m], psi_e (n,) [rad]."""
    ends: int = 0
    """The latest time [ns]."""

    @property
    def interval(self) -> float:
        """Length of a tick [s]."""
        return float(json.loads(self.scenario).get("control_interval", 0.01))

    @property
    def ticks(self) -> list[int]:
        """Ticks whose poses can be checked, in order."""
        return sorted(self.checks)

    @property
    def sorted_orders(self) -> list[RecordedOrder]:
        """In the order in which they count."""
        return sorted(self.orders, key=lambda order: (order.tick, order.number))

    def seconds(self, time: int) -> float:
        """Simulated time of a time on the record's clock [s]."""
        return (time - self.begins) * 1e-9


@dataclass(slots=True)
class Record:
    """What is in a file."""

    path: Path
    about: dict[str, str] = field(default_factory=dict)
    """run, version of the wire, detail, started [ns since the epoch]."""
    episodes: list[RecordedEpisode] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    """Messages by topic."""
    damage: list[Damage] = field(default_factory=list)
    ended: bool = False
    """Whether its writer closed it."""

    @property
    def sound(self) -> bool:
        """Whether ordinary readers read it: closed and undamaged."""
        return self.ended and not self.damage


def load(path: Path) -> Record:
    """Read a record, whatever state it is in.

    Raises:
        EchelonError: it cannot be read, or it is no record of a run.
    """
    record = Record(path)
    for item in scan(path):
        match item:
            case Message():
                record.counts[item.topic] += 1
                if record.episodes:
                    _take(record.episodes[-1], item)
            case Note("echelon", values):
                record.about = values
            case Note("episode", values):
                record.episodes.append(_episode(path, values))
            case Damage():
                record.damage.append(item)
            case End():
                record.ended = True
    if not record.about:
        raise EchelonError(f"expected a record of a run; {path} has no metadata of one")
    return record


def _episode(path: Path, values: dict[str, str]) -> RecordedEpisode:
    try:
        number, begins = int(values["number"]), int(values["begins"])
        resumed = tuple(map(int, json.loads(values.get("resumed", "[]"))))
        return RecordedEpisode(
            number, values["mode"], values["controller"], begins, values["scenario"], values["user_code"], resumed
        )
    except (KeyError, ValueError) as error:
        raise EchelonError(f"expected metadata of an episode in {path}; got {error}") from None


def _take(episode: RecordedEpisode, message: Message) -> None:
    fields = Fields(message.data)
    episode.ends = max(episode.ends, message.time)
    match message.kind.split("/")[-1]:
        case "Order":
            number, tick = fields.get("Q"), fields.get("Q")
            episode.orders.append(RecordedOrder(number, tick, fields.text(), json.loads(fields.text())))
        case "Checks":
            first, n = fields.get("Q"), fields.get("I")
            for row, sums in enumerate(fields.sequence("I").reshape(-1, n).tolist()):
                episode.checks[first + row] = tuple(sums)
        case "Ticks":
            first, n = fields.get("Q"), fields.get("I")
            poses, inputs = fields.sequence("d").reshape(-1, n, 3), fields.sequence("d").reshape(-1, n, 2)
            for row in range(len(poses)):
                episode.poses[first + row], episode.inputs[first + row] = poses[row], inputs[row]
        case "Odometry":
            fields.header()
            robot = int(fields.text().removeprefix("robot"))
            x, y, _, _, _, sine, cosine = fields.array("d", 7)
            fields.array("d", 36)
            twist = fields.array("d", 6)
            theta = 2.0 * math.atan2(sine, cosine)
            episode.shown[message.time, robot] = (x, y, math.remainder(theta, math.tau), twist[0], twist[5])
        case "Metrics":
            fields.header()
            tracking = float(fields.get("d"))
            episode.errors[message.time] = (tracking, np.array(fields.sequence("d")), np.array(fields.sequence("d")))
