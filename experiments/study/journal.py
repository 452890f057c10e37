"""Results of flights as they come in, one line each, so that a study that was interrupted goes on where it stopped."""

import fcntl
import json
from dataclasses import asdict
from pathlib import Path
from types import TracebackType

from experiments.study.flights import Result
from formation.errors import StudyError

NAME = "journal.jsonl"


class Journal:
    """An append-only file of results. Killed at any moment, it loses the line being written at most."""

    def __init__(self, folder: Path) -> None:
        """Open or begin the journal of a folder; nobody else may write to it meanwhile.

        Raises:
            StudyError: the folder cannot be written, or another study is writing there.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = (folder / NAME).open("a+b")
        except OSError as error:
            raise StudyError(f"--out: expected a folder that can be written; got {folder} ({error.strerror})") from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise StudyError(f"--out: another study is being flown into {folder}") from None
        self.results: dict[str, Result] = {}
        """By key; of this study and of any other that was flown into the same folder."""
        self._file.seek(0)
        text = self._file.read()
        for line in text.splitlines():
            self._read(line)
        if text and not text.endswith(b"\n"):  # killed while writing: what follows shall not be joined to it
            self._file.write(b"\n")

    def _read(self, line: bytes) -> None:
        """Take a line if it is whole."""
        try:
            found = json.loads(line)
            result = Result(**{**found, "series": tuple(found["series"])})
        except (ValueError, TypeError, KeyError):
            return
        self.results[result.key] = result

    def add(self, result: Result) -> None:
        """Write a result down; it survives the death of this process from here on. Raises StudyError."""
        self.results[result.key] = result
        try:
            self._file.write(json.dumps(asdict(result)).encode() + b"\n")
            self._file.flush()
        except OSError as error:
            raise StudyError(f"the journal cannot be written: {error.strerror}") from None

    def __enter__(self) -> "Journal":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()
