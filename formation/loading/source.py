"""What was named as code of a user's own, with the text that was read at that moment."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from formation.errors import ScenarioError

Kind = Literal["controller", "bodies"]
"""What a class of a user's own is for; also the option that names it."""
LOADED: "dict[tuple[Kind, str], Source]" = {}
"""All code of users' own that is loaded in this process, by kind and name."""
MAX_TEXT = 1 << 20
"""Bytes of one file."""


@dataclass(frozen=True, slots=True)
class Source:
    """A class of a user's own. Whoever holds this needs no file of the machine that read it."""

    kind: Kind
    name: str
    """By which scenarios and requests name it."""
    module: str
    """Absolute path of its file, or the dotted name of an installed module."""
    attribute: str
    """Name of the class."""
    texts: Mapping[str, str]
    """Of a file: its text and those of the files beside it that it imports, by path from its folder; else empty."""
    sha256: str
    """Of the text; of all texts, if there are several."""

    @property
    def origin(self) -> str:
        """Where it comes from, without the folder: "mine.py:HoldSlot"."""
        return f"{self.file.name if self.file else self.module}:{self.attribute}"

    @property
    def file(self) -> Path | None:
        """Its file; None for an installed module."""
        return Path(self.module) if self.module.endswith(".py") else None

    def to_json(self) -> str:
        """The text from which `from_json` makes the same value."""
        return json.dumps(asdict(self))


def loaded(kind: Kind) -> "dict[str, Source]":
    """What is loaded of a kind, by name."""
    return {name: source for (of, name), source in LOADED.items() if of == kind}


def admitted(source: Source) -> Source:
    """Note a source as loaded, under a name that no other file has: the class's, or that with a number."""
    name, number = source.name, 1
    while (held := LOADED.get((source.kind, name))) is not None and held.module != source.module:
        number += 1
        name = f"{source.attribute}-{number}"
    LOADED[source.kind, name] = renamed = replace(source, name=name)
    return renamed


def from_json(text: str, where: str) -> Source:
    """The source that `Source.to_json` wrote.

    Raises:
        ScenarioError: it is none, or its texts are not those of its hash.
    """
    try:
        raw: dict[str, Any] = json.loads(text)
        source = Source(**raw)
        sound = source.kind in get_args(Kind) and (not source.texts or digest(source.texts) == source.sha256)
    except (TypeError, ValueError, AttributeError):
        sound = False
    if not sound:
        raise ScenarioError(f"{where}: expected what a launcher wrote; got another text")
    return source


def digest(texts: Mapping[str, str]) -> str:
    """The SHA-256 of texts by path: of one text, that of its file."""
    if len(texts) == 1:
        return hashlib.sha256(next(iter(texts.values())).encode()).hexdigest()
    whole = hashlib.sha256()
    for path, text in sorted(texts.items()):
        whole.update(f"{path}\0{len(text)}\0{text}".encode())
    return whole.hexdigest()


def read(file: Path, where: str) -> str:
    """The text of a Python file.

    Raises:
        ScenarioError: it cannot be read, or is no UTF-8.
    """
    try:
        if not file.is_file():
            raise ScenarioError(f"{where}: expected a Python file; got {'a folder' if file.exists() else 'none there'}")
        if file.stat().st_size > MAX_TEXT:
            raise ScenarioError(f"{where}: expected at most {MAX_TEXT >> 20} MiB; got more")
        return file.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise ScenarioError(f"{where}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{where}: expected text in UTF-8; got other bytes") from None
