"""CDR, the encoding of ROS 2 messages: XCDR1, little-endian.

Four bytes of head, then the fields one after another, each aligned to its own size from the end of the head on.
"""

import struct
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

Code = Literal["b", "B", "i", "I", "Q", "f", "d"]
"""Of a primitive type, as in the modules struct and numpy."""
HEAD = b"\x00\x01\x00\x00"
"""Little-endian CDR, no options."""
_STRUCTS: dict[Code, struct.Struct] = {code: struct.Struct(f"<{code}") for code in ("b", "B", "i", "I", "Q", "f", "d")}
_ZEROS = bytes(8)


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
        encoded = text.encode()
        self.put("I", len(encoded) + 1)
        self._bytes += encoded + b"\x00"

    def octets(self, data: bytes) -> None:
        """A sequence of bytes."""
        self.put("I", len(data))
        self._bytes += data

    def _align(self, size: int) -> None:
        self._bytes += _ZEROS[: -(len(self._bytes) - len(HEAD)) % size]
