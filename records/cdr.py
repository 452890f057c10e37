"""CDR, the encoding of ROS 2 messages: XCDR1, little-endian.

Four bytes of head, then the fields one after another, each aligned to its own size from the end of the head on.
"""

import struct
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Code = Literal["b", "B", "i", "I", "Q", "f", "d"]
"""Of a primitive type, as in the modules struct and numpy."""
HEAD = b"\x00\x01\x00\x00"
"""Little-endian CDR, no options."""
_STRUCTS: dict[Code, struct.Struct] = {code: struct.Struct(f"<{code}") for code in ("b", "B", "i", "I", "Q", "f", "d")}
_ZEROS = bytes(8)


@lru_cache(maxsize=1024)
def string(text: str) -> bytes:
    """A string, encoded: names of frames and topics come again and again."""
    encoded = text.encode()
    return _STRUCTS["I"].pack(len(encoded) + 1) + encoded + b"\x00"


class Cdr:
    """A message that is being encoded, field by field."""

    def __init__(self) -> None:
        self._bytes = bytearray(HEAD)

    def __bytes__(self) -> bytes:
        return bytes(self._bytes)

    def put(self, code: Code, value: float) -> None:
        """A primitive field."""
        packer = _STRUCTS[code]
        self._align(packer.size)
        self._bytes += packer.pack(value)

    def array(self, code: Code, values: ArrayLike) -> None:
        """An array of fixed length."""
        numbers = np.ascontiguousarray(values, dtype=f"<{code}")
        if numbers.size:
            self._align(numbers.itemsize)
            self._bytes += numbers.tobytes()

    def sequence(self, code: Code, values: ArrayLike) -> None:
        """An array of any length: its length, then its entries."""
        self.put("I", np.size(values))
        self.array(code, values)

    def text(self, text: str) -> None:
        """A string: its length with the zero at its end, its bytes, the zero."""
        self.raw(string(text), 4)

    def raw(self, data: bytes, size: int) -> None:
        """Bytes that are encoded already, to be aligned to `size`."""
        self._align(size)
        self._bytes += data

    def octets(self, data: bytes) -> None:
        """A sequence of bytes."""
        self.put("I", len(data))
        self._bytes += data

    def _align(self, size: int) -> None:
        self._bytes += _ZEROS[: -(len(self._bytes) - len(HEAD)) % size]


class Fields:
    """A message that is being decoded, field by field."""

    def __init__(self, data: bytes) -> None:
        """At its first field. Raises ValueError if it is not little-endian CDR."""
        if data[: len(HEAD)] != HEAD:
            raise ValueError(f"expected little-endian CDR; got {data[: len(HEAD)]!r}")
        self._data, self._at = data, len(HEAD)

    @property
    def at(self) -> int:
        """Where the next field is looked for, in bytes from the beginning."""
        return self._at

    def get(self, code: Code) -> Any:
        """A primitive field."""
        packer = _STRUCTS[code]
        self._align(packer.size)
        (value,) = packer.unpack_from(self._data, self._at)
        self._at += packer.size
        return value

    def array(self, code: Code, length: int) -> NDArray[Any]:
        """An array of fixed length."""
        kind = np.dtype(f"<{code}")
        if length:
            self._align(kind.itemsize)
        found = np.frombuffer(self._data, kind, length, self._at)
        self._at += found.nbytes
        return found

    def sequence(self, code: Code) -> NDArray[Any]:
        """An array of any length."""
        return self.array(code, self.get("I"))

    def header(self) -> tuple[int, str]:
        """A std_msgs/Header: its time [ns] and its frame."""
        seconds, rest = self.get("i"), self.get("I")
        return seconds * 10**9 + rest, self.text()

    def text(self) -> str:
        """A string."""
        return self.octets()[:-1].decode()

    def octets(self) -> bytes:
        """A sequence of bytes."""
        length = self.get("I")
        self._at += length
        return self._data[self._at - length : self._at]

    def _align(self, size: int) -> None:
        self._at += -(self._at - len(HEAD)) % size
