"""Decodes a message by the schema that the file itself holds, as viewers do; written apart from the encoder."""

import re
import struct
from dataclasses import dataclass
from typing import Any

SIZES = {
    "bool": "?",
    "byte": "B",
    "uint8": "B",
    "int8": "b",
    "int32": "i",
    "uint32": "I",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
FIELD = re.compile(r"^([\w/]+)(\[(\d*)\])?\s+(\w+)")


def parsed(schema: str, name: str) -> dict[str, list[tuple[str, str | None, str]]]:
    """Fields of every type in a ros2msg schema: (type, None or length or "" for any length, name)."""
    first, *others = re.split(r"^=+\n", schema, flags=re.M)
    texts = {name.replace("/msg/", "/"): first}
    for other in others:
        head, _, text = other.partition("\n")
        texts[head.removeprefix("MSG: ").strip()] = text
    return {
        kind: [(m[1], m[3] if m[2] else None, m[4]) for line in text.splitlines() if (m := FIELD.match(line))]
        for kind, text in texts.items()
    }


@dataclass
class Reader:
    types: dict[str, list[tuple[str, str | None, str]]]
    data: bytes
    at: int = 4

    def primitive(self, kind: str) -> Any:
        if kind == "string":
            length = self.primitive("uint32")
            text = self.data[self.at : self.at + length - 1].decode()
            assert self.data[self.at + length - 1] == 0
            self.at += length
            return text
        code = SIZES[kind]
        size = struct.calcsize(code)
        self.at += -(self.at - 4) % size
        (value,) = struct.unpack_from(f"<{code}", self.data, self.at)
        self.at += size
        return value

    def one(self, kind: str) -> Any:
        return self.whole(kind) if "/" in kind else self.primitive(kind)

    def whole(self, kind: str) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for part, length, name in self.types[kind]:
            if length is None:
                found[name] = self.one(part)
            else:
                found[name] = [self.one(part) for _ in range(int(length) if length else self.primitive("uint32"))]
        return found


def decode(schema: str, name: str, data: bytes) -> dict[str, Any]:
    """The fields of a message; fails unless every byte is used."""
    assert data[:4] == b"\x00\x01\x00\x00"
    reader = Reader(parsed(schema, name), data)
    found = reader.whole(name.replace("/msg/", "/"))
    assert reader.at == len(data), f"{len(data) - reader.at} bytes are left of a {name}"
    return found
