"""A browser: without one these tests are skipped, on CI they fail."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.exceptions import chromium, needs

if TYPE_CHECKING:
    from playwright.sync_api import Browser

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-accelerated-2d-canvas",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--no-first-run",
)
"""docs/design.md, section 10: without a graphics card, other choices stall the page."""


@pytest.fixture(scope="package")
def browser() -> "Iterator[Browser]":
    """One for these tests only: Playwright's event loop would be in the way of tests that bring their own."""
    needs("playwright", "chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        yield started
        started.close()
