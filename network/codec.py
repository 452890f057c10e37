"""Messages to bytes and back: a CRC-32, then a MessagePack map with the message's type, version and fields.

Arrays are raw little-endian float64. Decoding untrusted bytes gives a message or a WireError, nothing
else. The CRC is there because a link may flip bytes: a damaged plan must count as lost, not move a robot.
"""

import dataclasses
import struct
import zlib
from typing import Any, TypeVar

import msgpack
import numpy as np
from pydantic import TypeAdapter, ValidationError

from formation.errors import WireError
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.user_code import UserCode
from formation.schema import MAX_SCENARIO
from network.messages import VERSION, Message
from network.stretch import Order
from network.topics import MESSAGES
from network.values import Driving, Event, Excursion, Intervention, LinkCounts, Motion, Pushed

MAX_BYTES = MAX_SCENARIO + (1 << 20)
_CRC = struct.Struct("<I")
_NAMES: dict[type[Any], str] = {kind: name for name, kind in MESSAGES.items()}
_FIELDS: dict[type[Any], tuple[str, ...]] = {
    kind: tuple(f.name for f in dataclasses.fields(kind))
    for kind in (*_NAMES, Motion, LinkCounts, Event, Driving, Order, Intervention, Pushed, Excursion)
}
_ADAPTERS: dict[type, TypeAdapter[Any]] = {}

M = TypeVar("M", bound=Message)


def encode(message: Message) -> bytes:
    """The message's bytes."""
    kind = type(message)
    body: dict[str, Any] = {"type": _NAMES[kind], "version": VERSION}
    for name in _FIELDS[kind]:
        body[name] = getattr(message, name)
    return seal(msgpack.packb(body, default=_plain, strict_types=True))


def seal(body: bytes) -> bytes:
    """The bytes with their CRC-32 in front."""
    return _CRC.pack(zlib.crc32(body)) + body


def unseal(payload: bytes) -> bytes:
    """The bytes behind a CRC-32.

    Raises:
        WireError: too short, too long, or damaged.
    """
    if not _CRC.size < len(payload) <= MAX_BYTES:
        raise WireError(f"expected {_CRC.size + 1} to {MAX_BYTES} bytes; got {len(payload)}")
    body = payload[_CRC.size :]
    if zlib.crc32(body) != _CRC.unpack_from(payload)[0]:
        raise WireError("expected a matching CRC-32")
    return body


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray):
        return np.ascontiguousarray(value, dtype="<f8").tobytes()
    if isinstance(value, LinkId):
        return str(value)
    if isinstance(value, Fault):
        return value.plain()
    if isinstance(value, UserCode):
        return value.model_dump()
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, float):  # numpy's
        return float(value)
    if type(value) in _FIELDS:
        return {name: getattr(value, name) for name in _FIELDS[type(value)]}
    raise TypeError(f"cannot be sent: {value!r}")


def decode(kind: type[M], payload: bytes) -> M:
    """The message of this kind that the bytes hold.

    Raises:
        WireError: they do not hold one; the text says in a line what was expected.
    """
    packed = unseal(payload)
    try:
        body = msgpack.unpackb(packed)
    except Exception as error:  # msgpack raises ValueError, its own types, RecursionError, ...
        raise WireError(f"expected MessagePack; {type(error).__name__}") from None
    if not isinstance(body, dict):
        raise WireError(f"expected a map; got {type(body).__name__}")
    name, version = body.pop("type", None), body.pop("version", None)
    if type(version) is not int or version != VERSION:
        raise WireError(f"expected a peer of wire version {VERSION}; got {version!r:.40}")
    if name != _NAMES[kind]:
        raise WireError(f"expected a {_NAMES[kind]}; got {name!r:.40}")
    try:
        message: M = _adapter(kind).validate_python(body)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(part) for part in first["loc"]) or name
        raise WireError(f"{place:.60}: {first['msg']}") from None
    return message


def _adapter(kind: type) -> TypeAdapter[Any]:
    """Made when the first message of a kind comes in: no process receives all kinds."""
    if kind not in _ADAPTERS:
        _ADAPTERS[kind] = TypeAdapter(kind)
    return _ADAPTERS[kind]
