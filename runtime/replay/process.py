"""Serves the page of a record, in this process: without a router, a world or agents."""

from collections.abc import Callable
from pathlib import Path

from dashboard.page import Page
from dashboard.serving import server
from dashboard.serving.access import Guard
from dashboard.telemetry.feed import Feed
from network.lifetime import Lifetime
from runtime.replay.source import RecordSource


def serve(guard: Guard, port: int, file: Path, other: Path | None, tell: Callable[[str], None]) -> None:
    """Serve until the process is told to stop.

    Args:
        guard: of the host, and of the token if there is one.
        port: 0: any free one.
        file: the record.
        other: another one, shown as its ghost.
        tell: is given the page's address once it can be opened.

    Raises:
        EchelonError: a file is no record, or the port is taken.
    """
    source = RecordSource(file, other)
    served = server.serve(guard, port, "Record")
    lifetime = Lifetime()
    try:
        page = Page(served, None, feed=Feed(source), name=source.name)
        tell(f"replay: {guard.address(served.get_port())}")
        page.serve(lifetime)
    finally:
        server.stop(served)
