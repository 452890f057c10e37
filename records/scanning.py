"""Reads any record from its beginning, also one without an index, cut short, or damaged in its middle."""

import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from formation.errors import EchelonError

_RECORD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
"""First and last time, size and CRC-32 of its records, length of the compression's name."""
_MESSAGE = struct.Struct("<HIQQ")
"""Channel, number, time of the log and of its publication; the data follow."""
_LENGTH = struct.Struct("<Q")
_COMPRESSION = b"zstd"
_SIGNATURE = struct.pack("<I", len(_COMPRESSION)) + _COMPRESSION
_SIGNATURE_AT = _RECORD.size + _CHUNK.size - 4
"""Where a chunk has it."""
_FOOTER_BYTES = _RECORD.size + 20 + len(MCAP0_MAGIC)
_IN_CHUNKS = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
"""What is nowhere else before the summary: elsewhere it is another record with a damaged first byte, and has no CRC."""
MAX_CHUNK = 1 << 28
"""A chunk whose records are said to be larger is damaged [bytes]."""


class Message(NamedTuple):
    """A message of a topic."""

    topic: str
    kind: str
    """Such as "nav_msgs/msg/Path"."""
    schema: str
    """Text of its definition."""
    time: int
    """[ns since the epoch]."""
    data: bytes


class Note(NamedTuple):
    """Metadata."""

    name: str
    values: dict[str, str]


class Damage(NamedTuple):
    """Bytes that cannot be read."""

    at: int
    length: int


class End(NamedTuple):
    """The file ends as its writer ended it, with an index."""


Item = Message | Note | Damage | End


class _DamagedError(Exception):
    """A record that cannot be read."""


def scan(path: Path, wants: Callable[[str], bool] = lambda _: True) -> Iterator[Item]:
    """Everything in a record, in the order of the file.

    Args:
        path: of the file.
        wants: whether messages of a topic are wanted; others are left out, which takes little time.

    Raises:
        EchelonError: it cannot be read, or it is no MCAP file.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise EchelonError(f"cannot read {path}: {error.strerror}") from None
    if not data.startswith(MCAP0_MAGIC):
        what = "an empty file" if not data else f"a file that begins with {data[:8]!r}"
        raise EchelonError(f"expected an MCAP file; got {what}: {path}")
    return _Scan(data, wants).items()


class _Scan:
    """One pass over the bytes of a file."""

    def __init__(self, data: bytes, wants: Callable[[str], bool]) -> None:
        self._data, self._wants = data, wants
        self._known: dict[int, tuple[str, str, str] | None] = {}
        """Topic, type and definition of each channel that messages came over; None if they are not wanted."""
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._over = False
        self._read_summary()

    def _read_summary(self) -> None:
        """Schemas and channels stand again at the end of a file that was closed: its first chunk may be damaged."""
        try:
            _, footer, _ = self._record(max(0, len(self._data) - _FOOTER_BYTES))
            (at,) = _LENGTH.unpack_from(footer)
            opcode: int = Opcode.SCHEMA if at else Opcode.FOOTER
            while opcode != Opcode.FOOTER:
                opcode, content, at = self._record(at)
                if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    list(self._read(opcode, content))
        except (_DamagedError, McapError, struct.error, ValueError):
            return

    def items(self) -> Iterator[Item]:
        at = len(MCAP0_MAGIC)
        while at < len(self._data) and not self._over:
            try:
                opcode, content, after = self._record(at)
                if opcode in _IN_CHUNKS:
                    raise _DamagedError
                yield from list(self._read(opcode, content))
            except (_DamagedError, McapError, struct.error, ValueError, KeyError, zstandard.ZstdError):
                after = self._next(at)
                yield Damage(at, after - at)
            at = after
        if self._over and self._data.endswith(MCAP0_MAGIC):
            yield End()

    def _record(self, at: int) -> tuple[int, bytes, int]:
        """Opcode, content, and where the next record begins."""
        if at + _RECORD.size > len(self._data):
            raise _DamagedError
        opcode, length = _RECORD.unpack_from(self._data, at)
        begins = at + _RECORD.size
        if not Opcode.HEADER <= opcode <= Opcode.DATA_END or begins + length > len(self._data):
            raise _DamagedError
        return opcode, self._data[begins : begins + length], begins + length

    def _read(self, opcode: int, content: bytes) -> Iterator[Item]:
        match opcode:
            case Opcode.CHUNK:
                yield from self._chunk(content)
            case Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(content)))
                self._schemas[schema.id] = schema
            case Opcode.CHANNEL:
                channel = Channel.read(ReadDataStream(BytesIO(content)))
                self._channels[channel.id] = channel
            case Opcode.MESSAGE:
                number, _, time, _ = _MESSAGE.unpack_from(content)
                known = self._known[number] if number in self._known else self._channel(number)
                if known is not None:
                    yield Message(*known, time, content[_MESSAGE.size :])
            case Opcode.METADATA:
                metadata = Metadata.read(ReadDataStream(BytesIO(content)))
                yield Note(metadata.name, metadata.metadata)
            case Opcode.DATA_END:
                self._over = True

    def _channel(self, number: int) -> tuple[str, str, str] | None:
        channel = self._channels[number]
        schema = self._schemas[channel.schema_id]
        known = (channel.topic, schema.name, schema.data.decode()) if self._wants(channel.topic) else None
        self._known[number] = known
        return known

    def _chunk(self, content: bytes) -> Iterator[Item]:
        _, _, size, crc, length = _CHUNK.unpack_from(content)
        compression = content[_CHUNK.size : _CHUNK.size + length]
        begins = _CHUNK.size + length + _LENGTH.size
        (packed,) = _LENGTH.unpack_from(content, begins - _LENGTH.size)
        if compression not in (b"", _COMPRESSION) or begins + packed != len(content) or size > MAX_CHUNK:
            raise _DamagedError
        records = content[begins:]
        if compression:
            records = zstandard.ZstdDecompressor().decompress(records, max_output_size=size)
        if len(records) != size or (crc and zlib.crc32(records) != crc):
            raise _DamagedError
        at = 0
        while at < size:
            opcode, length = _RECORD.unpack_from(records, at)
            at += _RECORD.size
            yield from self._read(opcode, records[at : at + length])
            at += length

    def _next(self, at: int) -> int:
        """Where to go on after damage: at the next record, if this one's length is sound, else at the next chunk."""
        if at + _RECORD.size <= len(self._data):
            after: int = at + _RECORD.size + _RECORD.unpack_from(self._data, at)[1]
            if after < len(self._data) and self._sound(after):
                return after
        found = at + 1 + _SIGNATURE_AT
        while (found := self._data.find(_SIGNATURE, found)) >= 0:
            if self._data[found - _SIGNATURE_AT] == Opcode.CHUNK and self._sound(found - _SIGNATURE_AT):
                return found - _SIGNATURE_AT
            found += 1
        return len(self._data)

    def _sound(self, at: int) -> bool:
        try:
            self._record(at)
        except _DamagedError:
            return False
        return True
