"""A record on disk while it is written: an MCAP file, readable up to its last flush whatever happens to its writer."""

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

from mcap.writer import CompressionType, Writer

from formation.errors import EchelonError
from records.definitions import full_name, schema

PROFILE = "ros2"
LIBRARY = "echelon"
CHUNK_BYTES = 1 << 19
"""A chunk is closed at this size, or with a flush."""


class RecordFile:
    """Writes messages to a new file. Use as a context manager: leaving it writes the index."""

    def __init__(self, path: Path) -> None:
        """Create the file. Raises EchelonError if there is one already, or it cannot be made."""
        try:
            self._stream = path.open("xb")
        except FileExistsError:
            raise EchelonError(f"expected the name of a new file; {path} exists") from None
        except OSError as error:
            raise EchelonError(f"cannot write {path}: {error.strerror}") from None
        self.path = path
        self._writer = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(PROFILE, LIBRARY)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._counts: dict[str, int] = {}

    @property
    def size(self) -> int:
        """Bytes on disk."""
        return os.fstat(self._stream.fileno()).st_size

    def write(self, topic: str, kind: str, stamp: int, data: bytes) -> None:
        """Add a message of a type such as "nav_msgs/Path" to a topic, with its time [ns]."""
        if topic not in self._channels:
            self._register(topic, full_name(kind), schema(kind))
        self._add(topic, stamp, data)

    def copy(self, topic: str, kind: str, text: str, stamp: int, data: bytes) -> None:
        """Add a message of another file, with its type's full name and definition there."""
        if topic not in self._channels:
            self._register(topic, kind, text)
        self._add(topic, stamp, data)

    def _add(self, topic: str, stamp: int, data: bytes) -> None:
        self._writer.add_message(self._channels[topic], stamp, data, stamp, self._counts[topic])
        self._counts[topic] += 1

    def _register(self, topic: str, kind: str, text: str) -> None:
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", text.encode())
        self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[kind])
        self._counts[topic] = 0

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Add metadata, which stands behind the messages before it: those of the open chunk too."""
        self.flush()
        self._writer.add_metadata(name, dict(values))

    def flush(self) -> None:
        """Close the chunk and hand everything to the operating system: from now on it outlives this process."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Write the index and close the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._stream.close()

    def abandon(self) -> None:
        """Close the file as it is: nothing more can be written."""
        with contextlib.suppress(OSError):
            self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
