"""Where a robot says that it is: poses out of Odometry, PoseStamped, TFMessage and turtlesim's Pose."""

import math
import struct
from typing import NamedTuple

from records.cdr import Fields
from ros.types import ODOMETRY, POSE_STAMPED, TF, TURTLE_POSES

BASES = ("base_link", "base_footprint")
"""Frames of a robot's body in /tf, with or without its namespace in front."""
MAP = "map"
MAX_TRANSFORMS, MAX_DEPTH = 1000, 16


class Place(NamedTuple):
    """A pose in the plane [m, m, rad]."""

    x: float
    y: float
    theta: float

    def then(self, other: "Place") -> "Place":
        """A place that is given in the frame of this one, in the frame that this one is given in."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        turned = Place(self.x + c * other.x - s * other.y, self.y + s * other.x + c * other.y, self.theta + other.theta)
        return turned._replace(theta=math.remainder(turned.theta, math.tau))


class Located(NamedTuple):
    """What a message says."""

    place: Place
    speed: tuple[float, float] | None = None
    """v, omega in the robot's frame [m/s, rad/s], if it says so."""


class PoseReader:
    """Reads one robot's messages; of /tf it keeps the newest transforms."""

    def __init__(self, kind: str, namespace: str = "") -> None:
        """For messages of a type of ros.types.POSES, of a robot in this namespace."""
        self._kind = kind
        prefix = namespace.strip("/")
        self._bases = [*(f"{prefix}/{base}" for base in BASES if prefix), *BASES]
        self._parents: dict[str, tuple[str, Place]] = {}

    def read(self, data: bytes) -> Located | None:
        """Where the robot is; None if a transform does not say so yet.

        Raises:
            ValueError: these are not the bytes of such a message, or a number is not finite.
        """
        try:
            found = self._read(Fields(data))
        except struct.error as error:
            raise ValueError(f"expected a whole {self._kind}; {error}") from None
        if found is not None and not all(map(math.isfinite, (*found.place, *(found.speed or ())))):
            raise ValueError("expected finite numbers")
        return found

    def _read(self, fields: Fields) -> Located | None:
        if self._kind == TF:
            return self._transforms(fields)
        if self._kind in TURTLE_POSES:
            x, y, theta, v, omega = fields.array("f", 5).tolist()
            return Located(Place(x, y, math.remainder(theta, math.tau)), (v, omega))
        fields.header()
        if self._kind == ODOMETRY:
            fields.text()
        place = _place(fields)
        if self._kind == POSE_STAMPED:
            return Located(place)
        fields.array("d", 36)
        twist = fields.array("d", 6)
        return Located(place, (float(twist[0]), float(twist[5])))

    def _transforms(self, fields: Fields) -> Located | None:
        moved = False
        for _ in range(min(fields.get("I"), MAX_TRANSFORMS)):
            _, parent = fields.header()
            child = fields.text().strip("/")
            if child in self._parents or len(self._parents) < MAX_TRANSFORMS:
                self._parents[child] = parent.strip("/"), _place(fields)
            moved = moved or child in self._bases
        base = next((name for name in self._bases if name in self._parents), None)
        return Located(place) if moved and base and (place := self._in_map(base)) else None

    def _in_map(self, frame: str) -> Place | None:
        """A frame in the map, if the way there is known."""
        place = Place(0.0, 0.0, 0.0)
        for _ in range(MAX_DEPTH):
            if frame == MAP:
                return place
            if frame not in self._parents:
                return None
            frame, own = self._parents[frame]
            place = own.then(place)
        return None


def _place(fields: Fields) -> Place:
    """A position and a quaternion, as the heading in the plane."""
    x, y, _, qx, qy, qz, qw = fields.array("d", 7).tolist()
    return Place(x, y, math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))
