"""Sessions with a run on another host, for orders and questions: keys that a code gave are kept until the run ends."""

import contextlib
import json
import shutil
from pathlib import Path

from formation.errors import EchelonError
from network.access.keys import Keys, host_and_port
from network.zenoh_bus import ZenohBus
from runtime.hosts.authority import write_private
from runtime.hosts.enrolment import enrol
from runtime.hosts.joined import write_keys
from runtime.run_registry import folder

KEPT = ".hosts"
"""Folder among those of this user's runs."""
_ENTRY = "run.json"


def connect(where: str, code: str | None, *, orders: bool, patience: float) -> ZenohBus:
    """A session with the run at HOST[:PORT].

    Args:
        where: host and port of its router.
        code: of an operator or an observer; None: the keys of the last time.
        orders: whether orders shall be given.
        patience: longest wait for the router [s].

    Raises:
        EchelonError: nobody is there, or who is there refuses.
    """
    host, port = host_and_port(where)
    place = folder() / KEPT / f"{host}_{port}".replace(":", ".")
    if code is not None:
        admission = enrol(host, port, code, ("operator", "observer"))
        shutil.rmtree(place, ignore_errors=True)
        write_keys(place, admission)
        (name,) = admission.certificates
        write_private(place / _ENTRY, json.dumps([admission.run, admission.control, name]))
    try:
        run, endpoint, name = json.loads((place / _ENTRY).read_text())
        keys = Keys.of(place, name)
    except (OSError, ValueError, EchelonError):
        raise EchelonError(
            f"expected --code CODE to get into the run at {where} (on its host: echelon invite operator)"
        ) from None
    if orders and name != "operator":
        raise EchelonError(f"expected the keys of an operator; got those of an {name}, who only listens")
    try:
        return ZenohBus(endpoint, run, keys=keys, patience=patience)
    except EchelonError as error:
        if "these keys" in str(error):
            forget(place)
            raise EchelonError(f"{error}. Get in anew: --code CODE (on its host: echelon invite {name})") from None
        raise


def forget(place: Path) -> None:
    """Remove keys that nobody accepts any more."""
    shutil.rmtree(place, ignore_errors=True)
    with contextlib.suppress(OSError):  # others are kept, or runs are live
        place.parent.rmdir()
        place.parent.parent.rmdir()
