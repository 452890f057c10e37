"""Results as they come in, one line each, so that an interrupted command goes on where it stopped."""

import fcntl
import hashlib
import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from formation.errors import EchelonError

NAME = "journal.jsonl"


def _digest(text: bytes) -> bytes:
    return hashlib.sha256(text).hexdigest()[:16].encode()


class Journal:
    """An append-only file of results. Killed at any moment, it loses the line being written at most."""

    def __init__(self, folder: Path) -> None:
        """Open or begin the journal of a folder; no other process may write to it meanwhile.

        Raises:
            EchelonError: the folder cannot be written, or another process is writing there.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = (folder / NAME).open("a+b")
        except OSError as error:
            raise EchelonError(
                f"--out: expected a folder that can be written; got {folder} ({error.strerror})"
            ) from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise EchelonError(f"--out: expected a folder of its own; another process is writing to {folder}") from None
        self.results: dict[str, dict[str, Any]] = {}
        """By key; of this command and of any other that wrote into the same folder."""
        self._file.seek(0)
        whole = True
        for line in self._file:
            self._read(line)
            whole = line.endswith(b"\n")
        if not whole:  # killed while writing: what follows shall not be joined to it
            self._file.write(b"\n")

    def _read(self, line: bytes) -> None:
        """Take a line if it is as it was written: complete, and not edited or damaged."""
        text, _, digest = line.rstrip(b"\n").rpartition(b" ")
        if _digest(text) != digest:
            return
        key, result = json.loads(text)
        self.results[key] = result

    def add(self, key: str, result: dict[str, Any]) -> None:
        """Write a result down; it survives the death of this process from here on. Raises EchelonError."""
        self.results[key] = result
        try:
            text = json.dumps([key, result]).encode()
            self._file.write(text + b" " + _digest(text) + b"\n")
            self._file.flush()
        except OSError as error:
            raise EchelonError(f"the journal cannot be written: {error.strerror}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()
