"""Types of the fields of messages: what decoding accepts, and refuses, of bytes that nobody trusts."""

from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field, PlainValidator

from formation.arrays import FloatArray
from formation.errors import FaultError
from formation.links import LinkId

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
"""Of every message: no other fields, no infinities."""


def _array(columns: int, rows: int | None = None) -> PlainValidator:
    """Accepts little-endian float64 bytes of so many columns (and rows); gives a read-only finite array."""

    def validate(data: object) -> FloatArray:
        if not isinstance(data, bytes) or not data or len(data) % (8 * columns):
            raise ValueError(f"expected bytes of {columns} float64 columns")
        array = _numbers(data)
        if rows is not None and array.size != rows * columns:
            raise ValueError(f"expected {rows * columns} numbers; got {array.size}")
        return array if rows == 1 else array.reshape(-1, columns)

    return PlainValidator(validate)


def _numbers(data: object) -> FloatArray:
    if not isinstance(data, bytes) or len(data) % 8:
        raise ValueError("expected bytes of float64 numbers")
    array = np.frombuffer(data, dtype="<f8")
    if not np.isfinite(array).all():
        raise ValueError("expected finite numbers")
    return array


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
Poses = Annotated[FloatArray, _array(3)]
"""(n, 3) [m, m, rad]."""
Pose = Annotated[FloatArray, _array(3, 1)]
"""(3,) [m, m, rad]."""
Inputs = Annotated[FloatArray, _array(2)]
"""(N, 2) v, omega [m/s, rad/s]."""
Numbers = Annotated[FloatArray, PlainValidator(_numbers)]
"""(n,)."""
Count = Annotated[int, Field(strict=True, ge=0, lt=2**63)]
Sender = Annotated[int, Field(strict=True, ge=0, le=64)]
Real = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(strict=True, gt=0.0)]
NonNegative = Annotated[float, Field(strict=True, ge=0.0)]
Text = Annotated[str, Field(strict=True, max_length=65536)]
LongText = Annotated[str, Field(strict=True, max_length=1 << 20)]
Flag = Annotated[bool, Field(strict=True)]
