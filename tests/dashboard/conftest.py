"""A page without a browser."""

from collections.abc import Iterator

import pytest

from dashboard.page import Page
from dashboard.serving import server
from formation.scenario.files import load
from tests.dashboard.fakes import page_of
from tests.dashboard.serving.served import Served


@pytest.fixture
def page() -> Iterator[Page]:
    """A page of three robots that nobody looks at."""
    with page_of(load("triangle-circle")) as made:
        yield made


@pytest.fixture
def served() -> Iterator[Served]:
    found = Served()
    yield found
    server.stop(found.server)
