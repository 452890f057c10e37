"""The live runs of this machine: a private folder each, with the router's socket and who leads it."""

import contextlib
import json
import os
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import IO, Self

from formation.errors import EchelonError, unknown
from network.run_folder import VARIABLE, lock, remove

RECORD = "run.json"
"""In a run's folder: what others need to know of it."""
PATIENCE_SECONDS = 0.5
"""How long a lock on the wished name is waited for."""
SOCKET_PATH_LIMIT = 107
"""Bytes that the path of a unix socket may have."""


@dataclass(frozen=True, slots=True)
class Run:
    """A live run."""

    name: str
    pid: int
    """Of its launcher."""
    endpoint: str
    """Its router's."""
    page: str
    """Address of its dashboard; empty if it has none."""


def folder() -> Path:
    """Where this user's runs are: $ECHELON_RUNS, or a folder for temporary files of the user's own.

    Raises:
        EchelonError: it is somebody else's, or not a folder.
    """
    given = os.environ.get(VARIABLE)
    base = Path(given) if given else Path(tempfile.gettempdir()) / f"echelon-{os.getuid()}"
    with contextlib.suppress(FileNotFoundError):
        if base.stat().st_uid != os.getuid() or not base.is_dir():
            raise EchelonError(f"expected {base} to be a folder of yours; set {VARIABLE} to one")
    return base


class Claim:
    """A name taken for a run; while it is held, nobody else can take it. Use as a context manager."""

    def __init__(self, name: str, *, page: str = "") -> None:
        """Take the name.

        Raises:
            EchelonError: a live run has it, or it cannot be a folder's name, or there can be no folder.
        """
        if not name.replace("-", "").replace("_", "").replace(".", "").isalnum() or not name[0].isalnum():
            raise EchelonError(f"--run: expected letters, digits, '-', '_' and '.'; got {name!r}")
        self.path = folder() / name
        self.endpoint = f"unixsock-stream/{self.path / 'router.sock'}"
        if len(os.fsencode(self.path / "router.sock")) > SOCKET_PATH_LIMIT:
            raise EchelonError(f"expected a shorter path for sockets than {self.path}; set {VARIABLE} to one")
        self._lock = self._take()
        (self.path / RECORD).write_text(json.dumps(asdict(Run(name, os.getpid(), self.endpoint, page))))

    def _take(self) -> IO[bytes]:
        """The lock; somebody who looks whether the run lives may hold it for a moment."""
        until = monotonic() + PATIENCE_SECONDS
        while True:
            try:
                self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            except OSError as error:
                raise EchelonError(f"expected a place for runs; {self.path.parent} cannot be used: {error}") from None
            held = lock(self.path)
            if held is not None:
                return held
            if monotonic() > until:
                taken = ", ".join(run.name for run in live())
                raise EchelonError(f"--run: expected a name that is not in use; got {self.path.name} (in use: {taken})")
            sleep(0.02)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        remove(self.path, self._lock)


def live() -> list[Run]:
    """The runs of this user whose launcher lives, by name. What killed ones left behind is removed."""
    found = []
    try:
        paths = sorted(path for path in folder().iterdir() if path.is_dir())
    except OSError:
        return []
    for path in paths:
        held = lock(path)
        if held is not None and (path / RECORD).exists():
            remove(path, held)
        elif held is not None:  # somebody is just claiming it
            held.close()
        else:
            with contextlib.suppress(OSError, ValueError, TypeError):
                found.append(Run(**json.loads((path / RECORD).read_text())))
    return found


def find(name: str | None) -> Run:
    """The live run of this name, or the only one.

    Raises:
        EchelonError: there is none, or several to choose from.
    """
    runs = live()
    if not runs:
        raise EchelonError("expected a live run to talk to; there is none. Start one: echelon up")
    if name is None:
        if len(runs) > 1:
            raise EchelonError(f"expected --run NAME; live runs: {', '.join(run.name for run in runs)}")
        return runs[0]
    for run in runs:
        if run.name == name:
            return run
    raise EchelonError(unknown("--run", name, [run.name for run in runs]))


def free_name(wish: str) -> str:
    """The wish, or the wish with the first number that is not in use."""
    taken = {run.name for run in live()}
    return next(name for name in (wish, *(f"{wish}-{n}" for n in range(2, 10_000))) if name not in taken)
