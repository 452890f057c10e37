"""The messages of a record, encoded. Times are nanoseconds since the epoch; frames are named as in /tf."""

import struct
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray
from network.values import Excursion
from records.cdr import HEAD, Cdr, string

MAP = "map"
"""The frame in which poses are."""
_TIME = struct.Struct("<iI")
"""Of a header: seconds, nanoseconds."""
_HEADER = np.dtype([("sec", "<i4"), ("nanosec", "<u4"), ("frame", f"V{len(string(MAP))}")])
_POSE_THEN_HEADER = np.dtype([("pose", "<f8", 7), *((name, _HEADER[name]) for name in _HEADER.names or ())])
"""A row of a Path, with the header of the next one: all are encoded at once, and stay aligned to 8."""
_STEPS = 2.0**16
"""Pictures are rounded to this part of a metre, or of 1 in a quaternion, so that they compress: to 15 um."""
LINE_LIST = 5
"""Of a Marker: its points are the ends of lines, two by two."""
Colour = tuple[float, float, float, float]


class Lines(NamedTuple):
    """Lines of one kind in a picture."""

    namespace: str
    points: FloatArray
    """(2 m, 2) the ends of m lines [m]."""
    colours: Sequence[Colour]
    """Of each line."""
    width: float
    """[m]."""


@lru_cache(maxsize=4)
def frames(robots: int) -> list[str]:
    """Names of the frames of so many robots: first their own, then their slots', and the centre's."""
    numbers = range(1, robots + 1)
    return [*(f"robot{i}" for i in numbers), *(f"slot{i}" for i in numbers), "centre"]


def _packed(stamp: int) -> bytes:
    return _TIME.pack(*divmod(stamp, 10**9))


def _time(cdr: Cdr, stamp: int) -> None:
    cdr.raw(_packed(stamp), 4)


def _header(cdr: Cdr, stamp: int, frame: str) -> None:
    cdr.raw(_packed(stamp) + string(frame), 4)


def _placed(poses: FloatArray) -> FloatArray:
    """Poses (n, 3) as x, y, z and a quaternion x, y, z, w (n, 7)."""
    found, half = np.zeros((len(poses), 7)), 0.5 * poses[:, 2]
    found[:, :2], found[:, 5], found[:, 6] = poses[:, :2], np.sin(half), np.cos(half)
    return found


def _drawn(poses: FloatArray) -> FloatArray:
    """As `_placed`, rounded (n, 7)."""
    return np.asarray(np.round(_placed(poses) * _STEPS) / _STEPS)


def _twists(velocities: FloatArray) -> FloatArray:
    """v and omega (n, 2) as linear x, y, z and angular x, y, z (n, 6)."""
    found = np.zeros((len(velocities), 6), "<f8")
    found[:, 0], found[:, 5] = velocities[:, 0], velocities[:, 1]
    return found


@lru_cache(maxsize=4096)
def _names(at: int, *texts: str) -> bytes:
    """What stands between a header's time, which begins `at` bytes after a multiple of 8, and floats: these strings."""
    cdr = Cdr()
    cdr.raw(bytes(at + _TIME.size), 1)
    for text in texts:
        cdr.text(text)
    cdr.raw(b"", 8)
    return bytes(cdr)[len(HEAD) + at + _TIME.size :]


def twist(velocity: FloatArray) -> bytes:
    """geometry_msgs/Twist of v, omega [m/s, rad/s]."""
    return HEAD + _twists(velocity[None]).tobytes()


def twist_stamped(stamp: int, frame: str, velocity: FloatArray) -> bytes:
    """geometry_msgs/TwistStamped of v, omega [m/s, rad/s]."""
    return twists_stamped(stamp, [frame], velocity[None])[0]


def twists_stamped(stamp: int, children: Iterable[str], velocities: FloatArray) -> list[bytes]:
    """geometry_msgs/TwistStamped of each row v, omega (n, 2) [m/s, rad/s] in its own frame."""
    begins = HEAD + _packed(stamp)
    return [begins + _names(0, child) + row.tobytes() for child, row in zip(children, _twists(velocities), strict=True)]


def odometries(stamp: int, children: Iterable[str], poses: FloatArray, velocities: FloatArray) -> list[bytes]:
    """nav_msgs/Odometry of each robot: its pose (n, 3) in the map, and its v, omega (n, 2) in its own frame."""
    begins = HEAD + _packed(stamp)
    rows = np.zeros((len(poses), 85), "<f8")
    rows[:, :7], rows[:, 43:49] = _placed(poses), _twists(velocities)  # each before its covariance
    return [begins + _names(0, MAP, child) + row.tobytes() for child, row in zip(children, rows, strict=True)]


def transforms(stamp: int, children: Sequence[str], poses: FloatArray) -> bytes:
    """tf2_msgs/TFMessage: where each frame is in the map, (n, 3)."""
    drawn = _drawn(poses).astype("<f8", copy=False)
    begins, found, at = _packed(stamp), [HEAD, struct.pack("<I", len(children))], 4
    for child, row in zip(children, drawn, strict=True):
        found += (begins, _names(at, MAP, child), row.tobytes())
        at = 0
    return b"".join(found)


def path(stamp: int, poses: FloatArray, stamps: Sequence[int]) -> bytes:
    """nav_msgs/Path of poses (N, 3) in the map, each with its time."""
    cdr = Cdr()
    _header(cdr, stamp, MAP)
    cdr.put("I", len(poses))
    if len(poses):
        _header(cdr, stamps[0], MAP)
        rows = np.zeros(len(poses), _POSE_THEN_HEADER)
        rows["pose"] = _drawn(poses)
        rows["sec"][:-1], rows["nanosec"][:-1] = np.divmod(np.array(stamps[1:], dtype=np.int64), 10**9)
        rows["frame"] = string(MAP)
        cdr.raw(rows.tobytes()[: -_HEADER.itemsize], 8)
    return bytes(cdr)


def markers(stamp: int, pictures: Iterable[Lines]) -> bytes:
    """visualization_msgs/MarkerArray: lines in the map."""
    cdr, drawn = Cdr(), list(pictures)
    cdr.put("I", len(drawn))
    for lines in drawn:
        _marker(cdr, stamp, lines)
    return bytes(cdr)


def _marker(cdr: Cdr, stamp: int, lines: Lines) -> None:
    _header(cdr, stamp, MAP)
    cdr.text(lines.namespace)
    cdr.array("i", (0, LINE_LIST, 0))  # id, type, action: add or change
    cdr.array("d", (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, lines.width, 0.0, 0.0))  # pose, scale
    cdr.array("f", (1.0, 1.0, 1.0, 1.0))
    cdr.array("i", (0, 0))  # lifetime: until the next
    cdr.put("B", 0)  # not locked to its frame
    cdr.put("I", len(lines.points))
    points = np.round(lines.points * _STEPS) / _STEPS
    cdr.array("d", np.column_stack([points, np.zeros(len(points))]))
    cdr.put("I", len(lines.points))
    cdr.array("f", np.repeat(np.array(lines.colours).reshape(-1, 4), 2, axis=0))
    cdr.text("")  # texture_resource, then texture
    _header(cdr, 0, "")
    cdr.text("")
    cdr.octets(b"")
    cdr.put("I", 0)  # uv_coordinates
    cdr.text("")  # text
    cdr.text("")  # mesh_resource, then mesh_file
    cdr.text("")
    cdr.octets(b"")
    cdr.put("B", 0)  # mesh_use_embedded_materials


LEVELS = {"info": 20, "warning": 30, "error": 40}
"""Of rcl_interfaces/Log, by the severity of an event."""


def log(stamp: int, severity: str, name: str, text: str) -> bytes:
    """rcl_interfaces/Log of an event."""
    cdr = Cdr()
    _time(cdr, stamp)
    cdr.put("B", LEVELS[severity])
    for field in (name, text, "", ""):
        cdr.text(field)
    cdr.put("I", 0)
    return bytes(cdr)


def metrics(stamp: int, tracking: float, distance: FloatArray, angle: FloatArray) -> bytes:
    """echelon_msgs/Metrics: the errors of a formation [m, m, rad]."""
    cdr = Cdr()
    _header(cdr, stamp, MAP)
    cdr.put("d", tracking)
    cdr.sequence("d", distance)
    cdr.sequence("d", angle)
    return bytes(cdr)


def link(
    stamp: int, name: str, age: float, counts: Iterable[int], solve: float, gap: float, way: tuple[float, bool]
) -> bytes:
    """echelon_msgs/Link: what an agent knows of its link [s], the counts of its messages, its solver, and its way.

    The way is how old its knowledge of the path is [s], and whether it is used up.
    """
    cdr = Cdr()
    _header(cdr, stamp, MAP)
    cdr.text(name)
    cdr.put("d", age)
    for count in counts:
        cdr.put("Q", count)
    cdr.put("d", solve)
    cdr.put("d", gap)
    cdr.put("d", way[0])
    cdr.put("B", way[1])
    return bytes(cdr)


def fault(stamp: int, link: str, values: Iterable[float]) -> bytes:
    """echelon_msgs/Fault: what is wrong with a link from now on, as in formation.faults.Fault; zeros: nothing."""
    cdr = Cdr()
    _header(cdr, stamp, MAP)
    cdr.text(link)
    for value in values:
        cdr.put("d", value)
    return bytes(cdr)


def contacts(stamp: int, clearance: float, gap: float) -> bytes:
    """echelon_msgs/Contacts: least distance now of two centres, and of two bodies; negative if they overlap [m]."""
    cdr = Cdr()
    _header(cdr, stamp, MAP)
    cdr.put("d", clearance)
    cdr.put("d", gap)
    return bytes(cdr)


def ticks(first: int, robots: int, poses: FloatArray, inputs: FloatArray) -> bytes:
    """echelon_msgs/Ticks: exact poses (T n, 3) from a tick on, and the inputs (T n, 2) that led there."""
    cdr = Cdr()
    cdr.put("Q", first)
    cdr.put("I", robots)
    cdr.sequence("d", poses)
    cdr.sequence("d", inputs)
    return bytes(cdr)


def checks(first: int, robots: int, sums: Sequence[int]) -> bytes:
    """echelon_msgs/Checks: a CRC-32 of each pose's bytes, tick by tick."""
    cdr = Cdr()
    cdr.put("Q", first)
    cdr.put("I", robots)
    cdr.sequence("I", sums)
    return bytes(cdr)


def order(number: int, tick: int, kind: str, value: str) -> bytes:
    """echelon_msgs/Order; the value is JSON."""
    cdr = Cdr()
    cdr.put("Q", number)
    cdr.put("Q", tick)
    cdr.text(kind)
    cdr.text(value)
    return bytes(cdr)


def wire(key: str, payload: bytes) -> bytes:
    """echelon_msgs/Wire: a message as it went over the wire."""
    cdr = Cdr()
    cdr.text(key)
    cdr.octets(payload)
    return bytes(cdr)


def excursion(stamp: int, one: Excursion) -> bytes:
    """echelon_msgs/Excursion; times are simulated [s], -1 for one that is not there."""
    cdr = Cdr()
    _header(cdr, stamp, MAP)
    cdr.put("I", one.number)
    cdr.put("I", one.robot)
    for value in (one.peak, one.peak_at, one.until, one.recovery):
        cdr.put("d", -1.0 if value is None else value)
    cdr.text(one.cause)
    cdr.put("d", -1.0 if one.cause_at is None else one.cause_at)
    return bytes(cdr)
