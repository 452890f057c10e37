"""A viser server that admits only the pages that the guard admits (dashboard/serving/admission.py).

viser itself listens on all hosts, takes another port if its own is taken, accepts web sockets from any web page that
a user has open, and lets any client open a public tunnel. All four are prevented here. What an admitted page may send
is in dashboard/serving/gate.py.
"""

import contextlib
import io
import os
import socket
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import viser
import websockets.asyncio.server
from viser import _messages
from viser.infra import _infra
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from dashboard.serving import shortcuts
from dashboard.serving.access import Guard
from dashboard.serving.admission import answer as answer_to
from dashboard.serving.admission import too_many
from dashboard.serving.front_page import with_prefix
from dashboard.serving.gate import LARGEST, PAGES, Gate
from dashboard.serving.icons import open_once
from formation.errors import EchelonError


def serve(guard: Guard, port: int, label: str) -> viser.ViserServer:
    """A server that listens on the guard's host and exactly this port (0: any free one).

    Raises:
        EchelonError: the port is taken or cannot be used.
    """
    bound = _bind(guard.host, port)
    taken = int(bound.getsockname()[1])
    original, gate = websockets.asyncio.server.serve, Gate()

    def guarded(handler: Any, _host: object, _port: object, *, process_request: Any, **options: Any) -> Any:
        def checked(connection: ServerConnection, request: Request) -> Response | None:
            answer = answer_to(guard, request.path, request.headers, taken)
            if answer is None and gate.pages >= PAGES and request.headers.get("Upgrade", "").lower() == "websocket":
                answer = too_many(PAGES)
            return answer if answer is not None else with_prefix(request.path, process_request(connection, request))

        options["max_size"] = LARGEST
        return original(handler, sock=bound, process_request=checked, **options)

    _GATES[taken] = gate
    open_once()
    shortcuts.take()
    _infra._message_consumer = _consume  # type: ignore[assignment]  # viser looks the name up for every page
    with _replaced(websockets.asyncio.server, "serve", guarded), quiet():
        os.environ.pop("_VISER_PORT_OVERRIDE", None)
        server = viser.ViserServer(host=guard.host, port=taken, label=label, verbose=False)
    gate.server = server
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)
    return server


_GATES: dict[int, Gate] = {}
"""By port."""


async def _consume(connection: ServerConnection, handle: Callable[[Any], None], kind: type) -> None:
    """In place of viser's loop over a page's messages."""
    await _GATES[int(connection.local_address[1])].consume(connection, handle, kind)


@contextlib.contextmanager
def _replaced(module: ModuleType, name: str, value: object) -> Iterator[None]:
    """Replace a name of a module for a while: viser takes no function that answers requests before it."""
    original = getattr(module, name)
    setattr(module, name, value)
    try:
        yield
    finally:
        setattr(module, name, original)


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


def stop(server: viser.ViserServer) -> None:
    """Close the port and stop viser's threads."""
    with quiet():
        server.stop()


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Discard what viser prints; standard output is for the address."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
