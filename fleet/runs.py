"""The live runs of this machine: a private folder each, with the router's socket and who leads it."""

import contextlib
import fcntl
import json
import os
import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Self

from formation.errors import EchelonError, unknown

VARIABLE = "ECHELON_RUNS"
"""Environment variable that names another folder for runs."""
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
    """Where this user's runs are: $ECHELON_RUNS, or a folder for temporary files of the user's own."""
    given = os.environ.get(VARIABLE)
    base = Path(given) if given else Path(tempfile.gettempdir()) / f"echelon-{os.getuid()}"
    base.mkdir(mode=0o700, parents=True, exist_ok=True)
    if base.stat().st_uid != os.getuid():
        raise EchelonError(f"expected {base} to be yours; set ECHELON_RUNS to a folder of your own")
    return base


class Claim:
    """A name taken for a run; while it is held, nobody else can take it. Use as a context manager."""

    def __init__(self, name: str, *, page: str = "") -> None:
        """Take the name.

        Raises:
            EchelonError: a live run has it, or it cannot be a folder's name.
        """
        if not name.replace("-", "").replace("_", "").replace(".", "").isalnum() or not name[0].isalnum():
            raise EchelonError(f"--run: expected letters, digits, '-', '_' and '.'; got {name!r}")
        self.path = folder() / name
        self.endpoint = f"unixsock-stream/{self.path / 'router.sock'}"
        if len(os.fsencode(self.path / "router.sock")) > SOCKET_PATH_LIMIT:
            raise EchelonError(f"expected a shorter path for sockets than {self.path}; set ECHELON_RUNS to one")
        self.path.mkdir(mode=0o700, exist_ok=True)
        self._lock = _locked(self.path)
        if self._lock is None:
            taken = ", ".join(run.name for run in live())
            raise EchelonError(f"--run: expected a name that is not in use; got {name} (in use: {taken})")
        (self.path / "run.json").write_text(json.dumps(asdict(Run(name, os.getpid(), self.endpoint, page))))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock is not None:
            self._lock.close()
        if not os.environ.get(VARIABLE):
            with contextlib.suppress(OSError):  # other runs are in it
                self.path.parent.rmdir()


def live() -> list[Run]:
    """The runs of this user whose launcher lives, by name. What others left behind is removed."""
    found = []
    for path in sorted(folder().iterdir()):
        lock = _locked(path) if path.is_dir() else None
        if lock is not None:  # nobody holds it: its launcher was killed
            shutil.rmtree(path, ignore_errors=True)
            lock.close()
            continue
        try:
            found.append(Run(**json.loads((path / "run.json").read_text())))
        except (OSError, ValueError, TypeError):
            continue
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


def _locked(path: Path) -> IO[bytes] | None:
    """The lock of a run's folder, or None if a launcher holds it. A killed launcher holds nothing."""
    try:
        lock = (path / "lock").open("ab")
    except OSError:
        return None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.close()
        return None
    return lock
