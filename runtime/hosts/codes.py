"""Codes that let somebody else into a run: good once, for ten minutes.

A code is twenty letters: the first twelve are of the fingerprint of the run's authority, so that who joins knows the
run; the last eight are a secret, so that the run knows who joins. The run keeps their hashes in its private folder.
"""

import fcntl
import hashlib
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any, Literal, get_args

from formation.errors import EchelonError
from runtime.hosts.authority import fingerprint, write_private

LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""Those that nobody mistakes for another: five bits each."""
_KNOWN, _SECRET = 12, 8
LIFE_SECONDS = 600.0
FILE = "codes.json"
Guest = Literal["agents", "operator", "observer"]
GUESTS: tuple[Guest, ...] = get_args(Guest)
"""What a code may let in: agents of robots, who gives orders, who only listens."""


def mark(authority: str) -> str:
    """The letters of a code that stand for an authority."""
    bits = int.from_bytes(fingerprint(authority, 8), "big")
    return "".join(LETTERS[bits >> 5 * n & 31] for n in range(_KNOWN))


def split(code: str) -> tuple[str, str]:
    """The mark of the authority and the secret; spaces, dashes and small letters are as good.

    Raises:
        EchelonError: it is no code.
    """
    plain = code.upper().replace("-", "").replace(" ", "")
    if len(plain) != _KNOWN + _SECRET or not set(plain) <= set(LETTERS):
        raise EchelonError(
            f"expected a code of {_KNOWN + _SECRET} letters and digits without 0, O, 1 and I; got {code!r:.40}"
        )
    return plain[:_KNOWN], plain[_KNOWN:]


class Codes:
    """The codes of a run, in its private folder: whoever may read it may invite."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / FILE

    def new(self, guest: Guest, authority: str) -> str:
        """A new code, with dashes."""
        secret = "".join(secrets.choice(LETTERS) for _ in range(_SECRET))
        with self._held() as held:
            now = monotonic()
            kept = {key: entry for key, entry in held.items() if now < entry["until"] + LIFE_SECONDS}
            held.clear()
            held.update(kept | {_hash(secret): {"guest": guest, "until": now + LIFE_SECONDS, "used": False}})
        text = mark(authority) + secret
        return "-".join(text[n : n + 4] for n in range(0, len(text), 4))

    def redeem(self, secret: str) -> Guest:
        """What the secret lets in, from now on no more.

        Raises:
            EchelonError: it lets nobody in.
        """
        with self._held() as held:
            entry = held.get(_hash(secret))
            if entry is None:
                raise EchelonError("expected a code of this run; this one is none")
            if entry["used"]:
                raise EchelonError("expected a new code (echelon invite); this one was used already")
            if monotonic() > entry["until"]:
                raise EchelonError("expected a new code (echelon invite); this one is older than ten minutes")
            entry["used"] = True
            guest: Guest = entry["guest"]
            return guest

    def give_back(self, secret: str) -> None:
        """The secret was not of use: it is good again."""
        with self._held() as held:
            held[_hash(secret)]["used"] = False

    @contextmanager
    def _held(self) -> Iterator[dict[str, Any]]:
        """The table; it is written back. Nobody else has it meanwhile."""
        folder = os.open(self._file.parent, os.O_RDONLY)
        try:
            fcntl.flock(folder, fcntl.LOCK_EX)
            held = json.loads(self._file.read_text()) if self._file.exists() else {}
            yield held
            write_private(self._file, json.dumps(held))
        finally:
            os.close(folder)


def _hash(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
