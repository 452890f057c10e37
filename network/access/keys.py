"""The keys with which a process shows its role, and how a router's endpoints are kept from strangers.

A run on one machine uses a unix socket in a private folder, which needs no keys. Everything else speaks TLS or QUIC,
and both ends show certificates of the run's own authority; the common name of a certificate is the role that it is for.
What a role may do is network/access/rules.py.
"""

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from formation.errors import EchelonError
from network.topics import Role

AUTHORITY = "authority.pem"
"""File in a folder of keys: the certificate of the run's authority."""
ENCRYPTED, OPEN = ("tls", "quic"), ("tcp", "udp")
"""Protocols of endpoints with keys and without."""
LOCAL = "unixsock-stream"
"""Protocol of the endpoint in a run's private folder."""
PORT = 7447
"""Where a router listens on a network, unless told otherwise."""


def common_name(role: Role, number: int = 0) -> str:
    """What a certificate calls a process: "world", "agent-3"."""
    return f"{role}-{number}" if number else role


@dataclass(frozen=True, slots=True)
class Keys:
    """A certificate, its key, and the authority that the other end must show a certificate of."""

    authority: Path
    certificate: Path
    key: Path

    @classmethod
    def of(cls, folder: Path, name: str) -> "Keys":
        """The keys of a common name in a folder.

        Raises:
            EchelonError: they are not there.
        """
        found = cls(folder / AUTHORITY, folder / f"{name}.pem", folder / f"{name}.key")
        missing = [path.name for path in (found.authority, found.certificate, found.key) if not path.is_file()]
        if missing:
            raise EchelonError(f"expected the keys of {name} in {folder}; {', '.join(missing)} is not there")
        return found

    def settings(self, *, listening: bool) -> dict[str, Any]:
        """Zenoh's settings for TLS and QUIC.

        Names are not compared: a host may have any address. Only the router's certificate is one of a server, so that
        no other process of the run can pass for it.
        """
        end = "listen" if listening else "connect"
        return {
            "root_ca_certificate": str(self.authority),
            "enable_mtls": True,
            "verify_name_on_connect": False,
            f"{end}_certificate": str(self.certificate),
            f"{end}_private_key": str(self.key),
        }


def protocol(endpoint: str) -> str:
    """The part of an endpoint before its first slash."""
    return endpoint.split("/", 1)[0]


def check(endpoint: str, keys: Keys | None, *, insecure: bool) -> None:
    """Refuse an endpoint that strangers could use. Raises EchelonError."""
    kind = protocol(endpoint)
    if kind in ENCRYPTED and keys is None:
        raise EchelonError(
            f"expected keys for {endpoint}; got none (--keys FOLDER; of another host's run: echelon join)"
        )
    if kind in OPEN and not insecure:
        raise EchelonError(
            f"expected an endpoint that strangers cannot use, such as tls/HOST:{PORT}; got {endpoint}. With --insecure "
            "nothing is encrypted, and whoever reaches it can read and command the robots"
        )


def host_and_port(text: str, default: int = PORT) -> tuple[str, int]:
    """Of HOST, HOST:PORT or [HOST]:PORT, where HOST is a name or an address.

    Raises:
        EchelonError: it is none of these.
    """
    bare = text.count(":") > 1 and not text.startswith("[")  # an address of IPv6
    with contextlib.suppress(ValueError):
        parts = urlsplit(f"//[{text}]" if bare else f"//{text}")
        port = default if parts.port is None else parts.port
        plain = not (parts.path or parts.query or parts.fragment or parts.username)
        if parts.hostname and plain and 0 < port < 65535:
            return parts.hostname, port
    raise EchelonError(f"expected HOST or HOST:PORT, such as 10.0.0.5:{default}; got {text!r:.80}")


def address(host: str, port: int) -> str:
    """HOST:PORT as endpoints have it."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
