"""Standard streams that are always there: closed ones are the null device, and what stderr cannot take is lost.

A closed stream is dangerous: the next file or socket that a process opens gets its number, and whatever prints there.
"""

import contextlib
import io
import os
import sys
from typing import TextIO

from formation.errors import EchelonError


class OutputError(EchelonError):
    """Standard output cannot take the results."""


class ReaderGoneError(OutputError):
    """Whoever reads standard output has enough."""


class _BestEffort(io.FileIO):
    """Lines for the user; without a reader, or without room, they are lost and nothing else."""

    def write(self, data: bytes) -> int:  # type: ignore[override]
        with contextlib.suppress(OSError):
            return super().write(data)
        return len(data)


class _Results(io.FileIO):
    """The results; that they cannot be written is said once, and what comes after is lost."""

    _lost = False

    def write(self, data: bytes) -> int:  # type: ignore[override]
        if self._lost:
            return len(data)
        try:
            return super().write(data)
        except BrokenPipeError:
            self._lost = True
            raise ReaderGoneError("nobody reads what is printed") from None
        except OSError as error:
            self._lost = True
            raise OutputError(f"what is printed cannot be written: {error.strerror}") from None


def open_streams(*, results: bool) -> None:
    """Give this process its three streams, whatever its caller left it.

    Args:
        results: whether somebody wants what it prints on stdout, and has to know if that is lost.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.BufferedReader(io.FileIO(0, closefd=False)))
    kind = _Results if results else _BestEffort
    sys.stdout = _text(kind(1, "w", closefd=False), sys.stdout, "strict")
    sys.stderr = _text(_BestEffort(2, "w", closefd=False), sys.stderr, "backslashreplace")


def _text(raw: io.FileIO, before: TextIO | None, errors: str) -> TextIO:
    """A text stream like the one before, or one of an ordinary kind."""
    lines = raw.fileno() == 2 or raw.isatty()
    encoding = "utf-8"
    if isinstance(before, io.TextIOWrapper):
        encoding, lines = before.encoding, lines or before.line_buffering or before.write_through
        errors = before.errors or errors
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding=encoding, errors=errors, line_buffering=lines)
