"""Where a run listens for other hosts."""

import errno
import socket
from dataclasses import dataclass
from typing import Literal

from formation.errors import EchelonError
from network.access.keys import address, host_and_port

Transport = Literal["tcp", "udp"]
DATAGRAMS = "quic/{}?rel=1;mixed_rel=1"
"""QUIC whose streams carry what must arrive, and whose datagrams the rest: like UDP, and encrypted like TLS.

After losses it holds datagrams back for some ten milliseconds at times, which plain UDP does not.
"""
_WILDCARDS = ("0.0.0.0", "::")


@dataclass(frozen=True, slots=True)
class Listening:
    """What a user wishes."""

    host: str
    port: int
    transport: Transport = "tcp"
    """Of plans, commands and ticks of agents on other hosts."""
    insecure: bool = False

    @classmethod
    def at(cls, text: str, transport: Transport = "tcp", *, insecure: bool = False) -> "Listening":
        """From HOST[:PORT].

        Raises:
            EchelonError: it is none, or not an address of this machine, or the port is taken.
        """
        found = cls(*host_and_port(text), transport, insecure)
        for port in (found.port,) if insecure else (found.port, found.port + 1):
            _check_free(found.host, port)
        return found

    @property
    def endpoints(self) -> tuple[str, ...]:
        """What the router listens on."""
        where = address(self.host, self.port)
        if self.insecure:
            return (f"tcp/{where}", *((f"udp/{where}",) if self.transport == "udp" else ()))
        return (f"tls/{where}", *((DATAGRAMS.format(where),) if self.transport == "udp" else ()))

    @property
    def agents(self) -> str:
        """What agents of other hosts connect to, with {} for HOST:PORT."""
        return DATAGRAMS if self.transport == "udp" else "tls/{}"

    @property
    def named(self) -> str:
        """HOST:PORT for somebody on another host."""
        return address("HOST" if self.host in _WILDCARDS else self.host, self.port)


def _check_free(host: str, port: int) -> None:
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
                raise EchelonError(f"--listen: expected an address of this machine; got {host!r}") from None
            raise EchelonError(
                f"--listen: expected two free ports of {host} from PORT on; {port} is taken or not allowed"
            ) from None
