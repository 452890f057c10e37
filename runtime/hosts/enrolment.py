"""Enrolment: who has a code shows it to the run, and gets certificates for the roles that it may play.

The run's authority is shown first, in the open: the code says whether it is the right one. What follows is encrypted,
and goes to nobody else than that authority's router, so the secret in the code does too.
"""

import contextlib
import json
import socket
import ssl
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from formation.errors import EchelonError
from network.access.keys import Keys, address, common_name
from network.access.robot_numbers import spelled
from network.access.rules import MAX_KEYED, members
from network.fields import harmless
from network.messages import VERSION
from runtime.hosts.authority import Authority, new_request
from runtime.hosts.codes import Codes, Guest, mark, split

SECONDS = 5.0
"""Time limit for each step of an enrolment [s]."""
ANSWER_SECONDS = 2.0 * SECONDS
"""How long an answer is waited for, perhaps behind somebody's wrong code [s]."""
MAX_LINE = 1 << 18
MAX_GUESTS = 8
"""Enrolments that go on at a time; further ones are turned away."""
WRONG_SECONDS = 1.0
"""After a wrong code nobody's is looked at for this long [s]: 40 bits of secret outlast ten minutes by far."""
PROMISED_SECONDS = 30.0
"""A robot whose certificate was given away counts as taken for this long, until its agent is there [s]."""


@dataclass(frozen=True, slots=True)
class Offer:
    """What those who join need to know of a run."""

    run: str
    port: int
    """Of the router."""
    parameters: str
    """What agents connect with: the endpoint around HOST:PORT, such as "tls/{}"."""


class Enrolment:
    """Answers those who want to join, in threads of its own, until it is closed."""

    def __init__(
        self,
        where: tuple[str, int],
        offer: Offer,
        folder: Path,
        authority: Authority,
        vacant: Callable[[], set[int]],
        tell: Callable[[str], None],
    ) -> None:
        """Listen.

        Args:
            where: host and port.
            offer: what those who are let in are told.
            folder: with the run's keys and codes.
            authority: of the run.
            vacant: robots whose agents other hosts may run, and that have none.
            tell: called with a line for the user.

        Raises:
            EchelonError: it cannot listen there.
        """
        self._offer, self._authority, self._vacant, self._tell = offer, authority, vacant, tell
        self._codes = Codes(folder)
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        keys = Keys.of(folder, "router")
        self._context.load_cert_chain(keys.certificate, keys.key)
        self._places = threading.BoundedSemaphore(MAX_GUESTS)
        self._one_at_a_time = threading.Lock()
        self._promised: dict[int, float] = {}
        try:
            family = socket.AF_INET6 if ":" in where[0] else socket.AF_INET
            self._socket = socket.create_server(where, family=family)
        except OSError as error:
            raise EchelonError(
                f"--listen: expected a free port for those who join; {address(*where)}: {error.strerror}"
            ) from None
        threading.Thread(target=self._serve, daemon=True).start()

    def close(self) -> None:
        """Answer nobody any more."""
        with contextlib.suppress(OSError):  # wakes the thread that accepts
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _serve(self) -> None:
        while True:
            try:
                guest, place = self._socket.accept()
            except OSError:
                return
            if self._places.acquire(blocking=False):
                threading.Thread(target=self._receive, args=(guest, place[0]), daemon=True).start()
            else:
                guest.close()

    def _receive(self, plain: socket.socket, host: str) -> None:
        try:
            with plain:
                plain.settimeout(SECONDS)
                _send(plain, {"echelon": VERSION, "authority": self._authority.pem})
                with self._context.wrap_socket(plain, server_side=True) as secured:
                    _send(secured, self._answer(_line(secured), host))
        except (OSError, ValueError, RecursionError):
            pass  # a stranger who does something else
        finally:
            self._places.release()

    def _answer(self, asked: dict[str, Any], host: str) -> dict[str, Any]:
        try:
            return self._admit(asked, host)
        except EchelonError as error:
            return {"refused": str(error)}

    def _admit(self, asked: dict[str, Any], host: str) -> dict[str, Any]:
        """The certificates of somebody with a code. Raises EchelonError: it is refused."""
        if asked.get("version") != VERSION:
            raise EchelonError(_other_version(asked.get("version")))
        secret = str(asked.get("secret"))
        with self._one_at_a_time:
            try:
                guest = self._codes.redeem(secret)
            except EchelonError:
                sleep(WRONG_SECONDS)
                raise
            try:
                if guest not in (asked.get("guests") or ()):
                    raise EchelonError(f"expected a code for something else; this one is for {guest}")
                names: list[str] = self._robots(asked.get("robots")) if guest == "agents" else [guest]
                certificates = self._authority.sign(str(asked.get("request")), names)
            except EchelonError:
                self._codes.give_back(secret)
                raise
        self._tell(f"{host} joined as {', '.join(names)}")
        offer = self._offer
        return {"run": offer.run, "port": offer.port, "parameters": offer.parameters, "certificates": certificates}

    def _robots(self, wished: object) -> list[str]:
        now = monotonic()
        vacant = self._vacant()
        free = {robot for robot in vacant if now >= self._promised.get(robot, 0.0)}
        if wished is not None:
            if not isinstance(wished, list) or not all(type(robot) is int for robot in wished):
                raise EchelonError("expected numbers of robots")
            taken = sorted(set(wished) - free)[:MAX_KEYED]
            if taken:
                raise EchelonError(f"expected robots without an agent, {spelled(free)}; got {spelled(taken)}")
            free = set(wished)
        if not free:
            raise EchelonError("expected a run with a robot that has no agent; every robot of this one has")
        self._promised |= dict.fromkeys(free, now + PROMISED_SECONDS)
        return [common_name("agent", robot) for robot in sorted(free)]


@dataclass(frozen=True, slots=True)
class Admission:
    """What somebody got for a code."""

    run: str
    endpoint: str
    """Of the router, for agents."""
    control: str
    """Of the router, for everybody else."""
    authority: str
    key: str
    certificates: dict[str, str]
    """By common name."""


def enrol(host: str, port: int, code: str, guests: Sequence[Guest], robots: list[int] | None = None) -> Admission:
    """Show a code to the run at HOST:PORT; enrolment is at the next port.

    Args:
        host, port: of the router.
        code: as it was printed there.
        guests: what the code may be for.
        robots: to run agents of; None: of all that have none.

    Raises:
        EchelonError: nobody is there, it is another run, or the code is refused.
    """
    known, secret = split(code)
    where = address(host, port + 1)
    try:
        with socket.create_connection((host, port + 1), ANSWER_SECONDS) as plain:
            shown = _line(plain)
            if shown.get("echelon") != VERSION:
                raise EchelonError(_other_version(shown.get("echelon")))
            authority = str(shown.get("authority"))
            if mark(authority) != known:
                raise EchelonError(f"expected a code of the run at {where}; this one is of another, or mistyped")
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            context.check_hostname = False  # the authority signs one server only
            context.load_verify_locations(cadata=authority)
            with context.wrap_socket(plain) as secured:
                key, request = new_request()
                _send(
                    secured,
                    {"version": VERSION, "secret": secret, "request": request, "robots": robots, "guests": guests},
                )
                answer = _line(secured)
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise EchelonError(f"expected a run that can be joined at {where} (echelon up --listen); {reason}") from None
    if "refused" in answer:
        raise EchelonError(harmless(str(answer["refused"])[:300]))
    try:
        router = address(host, int(answer["port"]))
        endpoint = str(answer["parameters"]).replace("{}", router)
        certificates = {str(name): str(pem) for name, pem in answer["certificates"].items()}
        if not certificates.keys() <= {common_name(*member) for member in members()}:  # they become names of files
            raise ValueError
        return Admission(str(answer["run"]), endpoint, f"tls/{router}", authority, key, certificates)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise EchelonError(f"expected certificates from {where}; got something else") from None


def _other_version(version: object) -> str:
    return f"expected a host with Echelon of wire version {VERSION}; got {version!r:.20}: install the same on both"


def _send(connection: socket.socket, message: dict[str, Any]) -> None:
    connection.sendall(json.dumps(message).encode() + b"\n")


def _line(connection: socket.socket) -> dict[str, Any]:
    """One line of JSON, byte by byte: TLS may begin right after it. Raises ValueError: it is none, OSError."""
    until, found = monotonic() + SECONDS, bytearray()
    while not found.endswith(b"\n"):
        if len(found) > MAX_LINE or monotonic() > until:
            raise ValueError("expected one line")
        got = connection.recv(1)
        if not got:
            raise ValueError("the connection was closed")
        found += got
    message = json.loads(found)
    if not isinstance(message, dict):
        raise ValueError("expected a table")
    return message
