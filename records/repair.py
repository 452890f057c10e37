"""Writes what can be read of a record into a new file that every reader reads."""

from dataclasses import dataclass
from pathlib import Path

from formation.errors import EchelonError
from records.file import RecordFile
from records.scanning import Damage, Message, Note, scan


@dataclass(frozen=True, slots=True)
class Repaired:
    """What came of it."""

    path: Path
    """The new file."""
    messages: int
    """That were read."""
    lost: int
    """Bytes that could not be read."""
    places: int
    """Where they are."""


def repair(path: Path, new: Path) -> Repaired:
    """Copy every message that can be read, and write the index.

    Args:
        path: the record.
        new: name of the new file.

    Raises:
        EchelonError: the record cannot be read at all, or the new file cannot be written.
    """
    items = scan(path)
    messages = lost = places = 0
    try:
        with RecordFile(new) as file:
            for item in items:
                match item:
                    case Message():
                        file.copy(item.topic, item.kind, item.schema, item.time, item.data)
                        messages += 1
                    case Note():
                        file.note(item.name, item.values)
                    case Damage():
                        lost, places = lost + item.length, places + 1
    except OSError as error:
        raise EchelonError(f"cannot write {new}: {error.strerror}") from None
    return Repaired(new, messages, lost, places)
