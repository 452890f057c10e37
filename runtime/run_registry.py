"""The live runs of this machine: a private folder each, with the router's socket and the launcher's entry."""

import contextlib
import fcntl
import json
import os
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import IO, Self
from urllib.parse import urlsplit

from formation.errors import EchelonError, unknown
from network.run_folder import VARIABLE, lock, remove

RECORD = "run.json"
"""File in a run's folder: what other commands need to know of the run."""
PATIENCE_SECONDS = 0.5
"""Longest wait for the lock of a run's name [s]."""
SOCKET_PATH_LIMIT = 107
"""Longest path of a unix socket [bytes]."""
NOT_IN_ENDPOINTS = "#?"
"""What begins something else in a Zenoh endpoint: the socket would lie at the path before it, outside the folder."""


@dataclass(frozen=True, slots=True)
class Run:
    """A live run."""

    name: str
    pid: int
    """Process id of its launcher."""
    endpoint: str
    """Endpoint of its router."""
    page: str
    """Address of its dashboard; empty if it has none."""
    joined: bool = False
    """Whether it is this host's part of another host's run, whose router its agents connect to."""


def folder() -> Path:
    """Folder of this user's runs: $ECHELON_RUNS, or a private one among the temporary files.

    Raises:
        EchelonError: it belongs to another user, or is not a folder.
    """
    given = os.environ.get(VARIABLE)
    base = Path(given) if given else Path(tempfile.gettempdir()) / f"echelon-{os.getuid()}"
    with contextlib.suppress(FileNotFoundError):
        if base.stat().st_uid != os.getuid() or not base.is_dir():
            raise EchelonError(f"expected {base} to be a folder of yours; set {VARIABLE} to one")
    return base


def check_path(path: Path) -> None:
    """Refuse a run's folder in which no socket can be. Raises EchelonError."""
    if any(character in str(path) for character in NOT_IN_ENDPOINTS):
        raise EchelonError(f"expected a path for sockets without # and ?; got {path}; set {VARIABLE} to one")
    if len(os.fsencode(path / "router.sock")) > SOCKET_PATH_LIMIT:
        raise EchelonError(f"expected a shorter path for sockets than {path}; set {VARIABLE} to one")


@contextlib.contextmanager
def _one_at_a_time(base: Path) -> Iterator[None]:
    """No other process of this user is in here meanwhile."""
    held = os.open(base, os.O_RDONLY)
    try:
        fcntl.flock(held, fcntl.LOCK_EX)
        yield
    finally:
        os.close(held)


class Claim:
    """A claimed name of a run; while it is held, no other process can claim it. Use as a context manager."""

    def __init__(self, name: str, *, page: str = "", joined: bool = False) -> None:
        """Take the name.

        Raises:
            EchelonError: a live run has it, or it cannot be a folder's name, or there can be no folder.
        """
        if not name.replace("-", "").replace("_", "").replace(".", "").isalnum() or not name[0].isalnum():
            raise EchelonError(f"--run: expected letters, digits, '-', '_' and '.'; got {name!r}")
        self.path = folder() / name
        check_path(self.path)
        self.endpoint = f"unixsock-stream/{self.path / 'router.sock'}"
        self._lock = self._take()
        try:
            with _one_at_a_time(self.path.parent):
                self._write(Run(name, os.getpid(), self.endpoint, page, joined))
        except BaseException as error:
            remove(self.path, self._lock)
            if isinstance(error, OSError):
                raise EchelonError(f"expected a place for runs; {self.path} cannot be used: {error.strerror}") from None
            raise

    def _write(self, run: Run) -> None:
        """Enter the run, unless another one has its page's port: a page takes some seconds to listen there."""
        port = urlsplit(run.page).port
        for other in live():
            if port is not None and urlsplit(other.page).port == port:
                raise EchelonError(f"--port: expected a free port; got {port}, which run {other.name} has")
        (self.path / RECORD).write_text(json.dumps(asdict(run)))

    def _take(self) -> IO[bytes]:
        """The lock; a process that checks whether the run is live may hold it for a moment."""
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
    """The runs of this user whose launcher is alive, by name. Folders of killed ones are removed."""
    found = []
    try:
        paths = sorted(path for path in folder().iterdir() if path.is_dir() and path.name[0] != ".")
    except OSError:
        return []
    for path in paths:
        held = lock(path)
        if held is not None and (path / RECORD).exists():
            remove(path, held)
        elif held is not None:  # another process is just claiming it
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
    runs = [run for run in live() if not run.joined]
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
    """The requested name, or that name with the first number that is not in use."""
    taken = {run.name for run in live()}
    return next(name for name in (wish, *(f"{wish}-{n}" for n in range(2, 10_000))) if name not in taken)
