"""Laws of enrolment: who has a code gets keys for what is vacant, from the run of the code, and from no other."""

import json
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from formation.errors import EchelonError
from network.messages import VERSION
from runtime.hosts import enrolment
from runtime.hosts.authority import Authority, new_request
from runtime.hosts.codes import GUESTS, split
from runtime.hosts.enrolment import WRONG_SECONDS, enrol
from runtime.hosts.listening import Listening
from runtime.hosts.reception import Reception

HOST = "127.0.0.1"
ANY = GUESTS


def two_free_ports() -> int:
    while True:
        with socket.socket() as one, socket.socket() as other:
            one.bind((HOST, 0))
            port: int = one.getsockname()[1]
            try:
                other.bind((HOST, port + 1))
            except OSError:
                continue
            return port


class Run:
    """A run that lets others in, and what it has told its user."""

    def __init__(self, folder: Path) -> None:
        self.vacant, self.told = {3, 4}, list[str]()
        self.port = two_free_ports()
        self.reception = Reception(Listening(HOST, self.port), "test", folder, lambda: self.vacant, self.told.append)


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Run]:
    found = Run(tmp_path)
    yield found
    found.reception.close()


def test_agents_get_certificates_for_what_is_vacant_and_nobody_gets_them_twice(run: Run) -> None:
    got = enrol(HOST, run.port, run.reception.invite("agents"), ANY)
    assert (got.run, got.endpoint) == ("test", f"tls/{HOST}:{run.port}")
    assert set(got.certificates) == {"agent-3", "agent-4"}
    assert any("agent-3, agent-4" in line for line in run.told)
    code = run.reception.invite("agents")
    with pytest.raises(EchelonError, match="every robot of this one has"):
        enrol(HOST, run.port, code, ANY)
    run.vacant = {3, 4, 5}  # the same code is good: it was of no use
    assert set(enrol(HOST, run.port, code, ANY).certificates) == {"agent-5"}


def test_a_host_may_choose_robots_but_only_vacant_ones(run: Run) -> None:
    code = run.reception.invite("agents")
    with pytest.raises(EchelonError, match="without an agent, 3-4; got 1"):
        enrol(HOST, run.port, code, ANY, [1, 3])
    assert set(enrol(HOST, run.port, code, ANY, [4]).certificates) == {"agent-4"}


def test_a_code_is_for_what_it_is_for(run: Run) -> None:
    code = run.reception.invite("observer")
    with pytest.raises(EchelonError, match="for observer"):
        enrol(HOST, run.port, code, ("agents",))
    assert set(enrol(HOST, run.port, code, ANY).certificates) == {"observer"}
    with pytest.raises(EchelonError, match="used already"):
        enrol(HOST, run.port, code, ANY)


def test_a_wrong_secret_costs_time(run: Run) -> None:
    known, _ = split(run.reception.invite("agents"))
    begun = time.monotonic()
    with pytest.raises(EchelonError, match="this one is none"):
        enrol(HOST, run.port, known + "ABCDEFGH", ANY)
    assert time.monotonic() - begun >= WRONG_SECONDS


def test_a_secret_is_shown_to_no_run_but_that_of_the_code(run: Run, tmp_path: Path) -> None:
    other = Run(tmp_path / "other")
    try:
        with pytest.raises(EchelonError, match="of another, or mistyped"):
            enrol(HOST, other.port, run.reception.invite("agents"), ANY)
        # Nor to one that shows the certificate of the right authority and cannot prove to be its router.
        other.reception._enrolment._authority = run.reception._authority
        with pytest.raises(EchelonError, match="certificate verify failed"):
            enrol(HOST, other.port, run.reception.invite("agents"), ANY)
    finally:
        other.reception.close()


def test_another_version_is_refused_at_the_door_by_both(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    code = run.reception.invite("agents")
    with socket.create_connection((HOST, run.port + 1)) as plain:
        shown = json.loads(plain.makefile().readline())
    assert shown["echelon"] == VERSION
    answer = run.reception._enrolment._answer({"version": VERSION + 1, "secret": split(code)[1]}, HOST)
    assert f"wire version {VERSION}" in answer["refused"]
    monkeypatch.setattr(enrolment, "VERSION", VERSION + 1)  # from here on of both
    monkeypatch.setattr(enrolment, "_send", lambda connection, message: connection.sendall(b'{"echelon": 1}\n'))
    with pytest.raises(EchelonError, match=f"wire version {VERSION + 1}; got 1"):
        enrol(HOST, run.port, code, ANY)


@pytest.mark.parametrize("junk", [b"", b"GET / HTTP/1.0\r\n\r\n", b"\x16\x03\x01" + b"\xff" * 500, b"[" * 9000 + b"\n"])
def test_junk_ends_nothing(run: Run, junk: bytes) -> None:
    with socket.create_connection((HOST, run.port + 1)) as plain:
        plain.makefile().readline()
        plain.sendall(junk)
    assert enrol(HOST, run.port, run.reception.invite("operator"), ANY).certificates.keys() == {"operator"}


@pytest.mark.parametrize("request_", ["", "-----BEGIN", new_request()[0], Authority().pem])
def test_only_a_signing_request_is_signed(request_: Any) -> None:
    with pytest.raises(EchelonError, match="signing request"):
        Authority().sign(request_, ["operator"])
