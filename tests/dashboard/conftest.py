"""A page without a browser."""

from collections.abc import Iterator

import pytest

from dashboard.page import Page
from dashboard.serving import server
from dashboard.serving.access import Guard
from dashboard.serving.server import serve
from network import topics
from network.codec import encode
from tests.builders import state
from tests.dashboard.fakes import bus, receive
from tests.dashboard.serving.served import Served


@pytest.fixture
def page() -> Iterator[Page]:
    """A page of three robots that nobody looks at."""
    served = serve(Guard("127.0.0.1"), 0, "x")
    made = Page(served, bus())
    assert receive(made._feed.source, topics.state("x"), encode(state()))
    made._feed.source.update_scenario()
    assert made._frame() == 3
    yield made
    server.stop(served)


@pytest.fixture
def served() -> Iterator[Served]:
    found = Served()
    yield found
    server.stop(found.server)
