"""Why a router refuses the keys of a process, or is refused for its own: Zenoh itself only says that time is over.

Imported once a connection has failed: Python's own TLS takes 30 ms to import, which no process needs to start.
"""

import socket
import ssl

from network.access.keys import Keys, host_and_port

HANDSHAKE_SECONDS = 2.0
"""Time limit for a handshake that finds out why a connection is refused [s]."""


def refusal(endpoint: str, keys: Keys) -> str | None:
    """The reason; None if that is not it. A router with QUIC listens with TLS at the same port."""
    host, port = host_and_port(endpoint.split("/", 1)[1].split("?", maxsplit=1)[0])
    try:
        with (
            socket.create_connection((host, port), HANDSHAKE_SECONDS) as plain,
            _context(keys).wrap_socket(plain) as secured,
        ):
            secured.settimeout(HANDSHAKE_SECONDS)
            secured.recv(1)  # what is refused is refused now, with TLS 1.3
    except ssl.SSLCertVerificationError:
        return f"what answers at {endpoint} is not the router of the run that these keys are for"
    except ssl.SSLError as error:
        if "ALERT" in (error.reason or ""):
            return f"the router at {endpoint} refuses these keys: they are of another run"
    except OSError:
        pass
    return None


def _context(keys: Keys) -> ssl.SSLContext:
    """What `Keys.settings` says, for Python's own TLS as a client."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.load_verify_locations(keys.authority)
    context.load_cert_chain(keys.certificate, keys.key)
    return context
