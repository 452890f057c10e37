"""Types of the fields of messages: what decoding accepts, and refuses, of untrusted bytes."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, PlainValidator

from formation.arrays import FloatArray, frozen
from formation.errors import FaultError
from formation.link_ids import LinkId
from formation.schema import MAX_ROBOTS, MAX_SCENARIO

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
"""Of every message: no other fields, no infinities."""


LARGEST = 1e16
"""Of any number in a message: whatever it counts or measures, one can compute with its square."""
SHORT = 64
"""Of so few numbers Python computes the length in a third of the time that numpy takes to look at each."""
_FLOAT = np.dtype("<f8")
_NOTHING = {columns: frozen(np.zeros((0, columns))) for columns in range(1, 12)}
"""Of each number of columns: most arrays of a message are empty."""
_CONTROL = dict.fromkeys([*range(0x09), *range(0x0B, 0x20), *range(0x7F, 0xA0), *range(0x202A, 0x202F)], "\ufffd")
"""Characters that a terminal obeys or that turn the direction of a text, but for the end of a line and a tab."""


def harmless(text: str) -> str:
    """The text as it may be printed anywhere."""
    return text if text.isprintable() else text.translate(_CONTROL)


def _bounded(array: FloatArray) -> bool:
    """Whether all are numbers, and none is too large."""
    if len(array) <= SHORT and math.hypot(*array.tolist()) <= LARGEST:
        return True
    return bool((np.abs(array) <= LARGEST).all())


@dataclass(frozen=True, slots=True)
class ArrayOf:
    """Accepts the little-endian float64 bytes of an array; gives it finite and read-only."""

    columns: int | None = None
    """None for an array of one dimension, of any length."""
    rows: int | None = None
    """None for one or more; with 1 the array has one dimension."""
    empty: bool = False
    """Whether there may be no rows."""
    most: tuple[float, ...] | None = None
    """By column, the largest absolute value."""

    def __call__(self, data: object) -> FloatArray:
        columns = self.columns or 1
        if data == b"" and self.empty:
            return _NOTHING[columns]
        if not isinstance(data, bytes) or len(data) % (8 * columns) or (self.columns and not data):
            raise ValueError(f"expected bytes of {columns} float64 columns")
        array = np.frombuffer(data, _FLOAT)
        if not _bounded(array):
            raise ValueError(f"expected numbers up to {LARGEST:g}")
        if self.rows is not None and array.size != self.rows * columns:
            raise ValueError(f"expected {self.rows * columns} numbers; got {array.size}")
        if self.most is not None and np.any(np.abs(array.reshape(-1, columns)) > self.most):
            raise ValueError(f"expected numbers up to {self.most}")
        return array if self.columns is None or self.rows == 1 else array.reshape(-1, columns)


def _link(data: object) -> LinkId:
    if isinstance(data, LinkId):
        return data
    if not isinstance(data, str):
        raise ValueError("expected the name of a link")
    try:
        return LinkId.parse(data)
    except FaultError as error:
        raise ValueError(str(error)) from None


Link = Annotated[LinkId, PlainValidator(_link)]
"""A directed link; on the wire its text."""
Poses = Annotated[FloatArray, PlainValidator(ArrayOf(3))]
"""(n, 3) [m, m, rad]."""
Pose = Annotated[FloatArray, PlainValidator(ArrayOf(3, 1))]
"""(3,) [m, m, rad]."""
Inputs = Annotated[FloatArray, PlainValidator(ArrayOf(2))]
"""(N, 2) v, omega [m/s, rad/s]."""
Velocity = Annotated[FloatArray, PlainValidator(ArrayOf(2, 1))]
"""(2,) [m/s, m/s] in the world frame, or [m/s, rad/s] of the body."""
MaybePoses = Annotated[FloatArray, PlainValidator(ArrayOf(3, empty=True))]
"""(n or 0, 3) [m, m, rad]."""
Places = Annotated[FloatArray, PlainValidator(ArrayOf(2, empty=True))]
"""(n or 0, 2) [m, m]."""
Seen = Annotated[FloatArray, PlainValidator(ArrayOf(3, empty=True))]
"""(m, 3) who sees whom, i n + j for robot row i and body row j, ascending; where that is, x, y [m]."""
Sums = Annotated[FloatArray, PlainValidator(ArrayOf(4, empty=True))]
"""(hops, 4) integrals of v and omega [m, rad], the tick before which they end, and that at which they began."""
Measurements = Annotated[FloatArray, PlainValidator(ArrayOf(9, empty=True))]
"""(m, 9) hop, tick, 1 if localised, x, y, theta, 1 if related, x, y."""
News = Annotated[FloatArray, PlainValidator(ArrayOf(4, empty=True))]
"""(m, 4) robot row, need [s], its rate, tick."""
Way = Annotated[FloatArray, PlainValidator(ArrayOf(6, empty=True))]
"""(m, 6) tick, and there the path's time [s], x, y of the formation's centre [m], the path's heading, and which way the
formation faces [rad]."""
FAR, ROUND, FAST = 1e7, 1e6, 100.0
"""Bounds of what a driver sends: places [m], angles [rad], speeds [m/s, rad/s]."""
Far = Annotated[float, Field(strict=True, ge=-FAR, le=FAR)]
Fast = Annotated[float, Field(strict=True, ge=-FAST, le=FAST)]
Drive = Annotated[
    FloatArray,
    PlainValidator(
        ArrayOf(11, empty=True, most=(2.0**53, 2.0**53, FAR, FAR, ROUND, ROUND, FAST, FAST, FAST, FAST, FAST))
    ),
]
"""(1 or 0, 11) number of the message, tick, and there x, y of the formation's centre [m], its heading, which way the
formation faces [rad], its v, omega and rotation [m/s, rad/s, rad/s]; the v and omega that are ordered."""
Numbers = Annotated[FloatArray, PlainValidator(ArrayOf())]
"""(n,)."""
Count = Annotated[int, Field(strict=True, ge=0, lt=2**63)]
Sender = Annotated[int, Field(strict=True, ge=0, le=MAX_ROBOTS)]
Real = Annotated[float, Field(strict=True, ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(strict=True, gt=0.0, le=LARGEST)]
NonNegative = Annotated[float, Field(strict=True, ge=0.0, le=LARGEST)]
Text = Annotated[str, Field(strict=True, max_length=65536), AfterValidator(harmless)]
LongText = Annotated[str, Field(strict=True, max_length=MAX_SCENARIO)]
Flag = Annotated[bool, Field(strict=True)]
