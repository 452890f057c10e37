"""A viser server that only this machine's own pages can use.

viser itself listens everywhere, walks to another port if its own is taken, accepts web sockets from any web page that
a person has open, and lets any client open a public tunnel. All four are closed here.
"""

import contextlib
import io
import os
import socket
from collections.abc import Iterator
from typing import Any
from unittest import mock

import viser
import websockets.asyncio.server
from viser import _messages
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from formation.errors import EchelonError

LOOPBACK = ("127.0.0.1", "::1", "localhost")
IN_CONTAINER = "ECHELON_IN_CONTAINER"
"""Environment variable that allows another host than loopback: the container publishes its port on loopback only."""


def check_host(host: str) -> None:
    """Refuse to serve others than this machine.

    Raises:
        EchelonError: `host` is not loopback, and this is not a container of ours.
    """
    if host not in LOOPBACK and os.environ.get(IN_CONTAINER) != "1":
        raise EchelonError(
            f"--host: expected one of {', '.join(LOOPBACK)}, because anybody who reaches the page controls the run; "
            f"got {host!r}. "
            "From another machine, tunnel to it: ssh -L 8090:127.0.0.1:8090 HOST"
        )


def serve(host: str, port: int, label: str) -> viser.ViserServer:
    """A server that listens on exactly this port (0: any free one).

    Raises:
        EchelonError: the port is taken or cannot be used.
    """
    check_host(host)
    bound = _bind(host, port)
    original = websockets.asyncio.server.serve

    def guarded(handler: Any, _host: object, _port: object, *, process_request: Any, **options: Any) -> Any:
        def checked(connection: ServerConnection, request: Request) -> Response | None:
            refusal = refused(request.headers)
            return refusal if refusal is not None else process_request(connection, request)

        return original(handler, sock=bound, process_request=checked, **options)

    with mock.patch.object(websockets.asyncio.server, "serve", guarded), quiet():
        os.environ.pop("_VISER_PORT_OVERRIDE", None)
        server = viser.ViserServer(host=host, port=bound.getsockname()[1], label=label, verbose=False)
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)
    return server


def address(host: str, port: int) -> str:
    """Where a person finds the page: always under a name that `refused` lets pass."""
    if host not in LOOPBACK:  # a container listens on all of its own addresses, and publishes the port on loopback
        host = LOOPBACK[0]
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _bind(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family, socket.SOCK_STREAM)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind((host, port))
        bound.listen(64)
    except (OSError, OverflowError) as error:
        bound.close()
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise EchelonError(
            f"--port: expected a free port on {host}; got {port} ({reason}). Choose another, or 0 for any free one"
        ) from None
    return bound


def refused(headers: Headers) -> Response | None:
    """403 for a request that comes from another site's page, or under a name that is not this machine's.

    A browser sends the Origin of the page with every web socket. It must be the address that was asked for (Host), and
    that must be loopback: else a page could give its own name our address (DNS rebinding).
    """
    origins, hosts = headers.get_all("Origin"), headers.get_all("Host")
    host = hosts[0].lower() if len(hosts) == 1 else ""
    known = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
    if known not in ("127.0.0.1", "localhost", "[::1]"):
        return _forbidden("expected the host 127.0.0.1 or localhost")
    if headers.get("Upgrade", "").lower() == "websocket" and origins != [f"http://{host}"]:
        return _forbidden("expected this page's own origin")
    return None


def _forbidden(text: str) -> Response:
    body = f"{text}\n".encode()
    return Response(403, "Forbidden", Headers({"Content-Type": "text/plain", "Content-Length": str(len(body))}), body)


def stop(server: viser.ViserServer) -> None:
    """Close the port and end viser's threads."""
    with quiet():
        server.stop()


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Swallow what viser prints about itself; standard output is for the address."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
