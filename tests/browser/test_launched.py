"""A run that `echelon up` started, on a page that wants a token: agents are killed and come back."""

import functools
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

from network.messages import State
from runtime.precompile import ensure_compiled
from tests.browser.browser_run import ROOT
from tests.browser.driven import Driven
from tests.browser.watch import Watch

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]
TOKEN = "a-token-for_the-test"
RUN = "launched"


class Launched:
    """`echelon up` with two robots."""

    def __init__(self, folder: str) -> None:
        words = ["up", "circle", "--run", RUN, "--port", "0", "--token", TOKEN, "--set", "duration=125"]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "cli.main", *words],
            cwd=ROOT,
            text=True,
            env={**os.environ, "ECHELON_RUNS": folder},
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._watch = Watch(f"unixsock-stream/{folder}/{RUN}/router.sock", RUN)

    @functools.cached_property
    def url(self) -> str:
        """The page's address, without its token."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        found = re.fullmatch(rf"dashboard: (http://127\.0\.0\.1:\d+)/\?token={TOKEN}\n", line)
        assert found, f"expected the dashboard's address with its token; got {line!r}"
        return found[1]

    def state(self) -> State:
        """The next state."""
        return self._watch.state()

    def end(self) -> None:
        """As with Ctrl-C."""
        self._watch.close()
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(20)
        finally:
            self._process.kill()
            assert self._process.stdout is not None
            self._process.stdout.close()


@pytest.fixture(scope="module")
def launched(browser: "Browser") -> Iterator[Launched]:
    ensure_compiled(print)
    with tempfile.TemporaryDirectory(prefix="ech") as folder:
        run = Launched(folder)
        try:
            yield run
        finally:
            run.end()


@pytest.fixture(scope="module")
def page(browser: "Browser", launched: Launched) -> Iterator[Driven]:
    driven = Driven(browser, launched.url, token=TOKEN)
    yield driven
    driven.page.close()


def test_the_first_visit_leaves_a_strict_cookie_and_no_token_in_the_address(page: Driven, launched: Launched) -> None:
    assert page.page.url == f"{launched.url}/?fixedDpr=1"
    (cookie,) = page.page.context.cookies()
    assert cookie["name"] == f"echelon-{urlsplit(launched.url).port}"
    assert (cookie["httpOnly"], cookie["sameSite"]) == (True, "Strict")
    assert page.errors == []


def test_without_the_token_the_page_says_what_to_do(browser: "Browser", launched: Launched) -> None:
    import viser
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect
    from websockets.typing import Origin, Subprotocol

    stranger = browser.new_page()
    for path in ("", "/?token=wrong", "/index.html"):
        answer = stranger.goto(launched.url + path)
        assert answer is not None
        assert answer.status == 401
        assert "echelon status" in stranger.locator("body").inner_text()
    assert stranger.context.cookies() == []
    stranger.close()
    address, protocol = launched.url.replace("http", "ws"), [Subprotocol(f"viser-v{viser.__version__}")]
    cookie = {"Cookie": f"echelon-{urlsplit(launched.url).port}={TOKEN}"}
    for origin, headers, code in ((launched.url, {}, 401), ("http://evil.example", cookie, 403)):
        with pytest.raises(InvalidStatus, match=str(code)):
            connect(address, origin=Origin(origin), subprotocols=protocol, additional_headers=headers)
    own = Origin(launched.url)
    with connect(address, origin=own, subprotocols=protocol, additional_headers=cookie, max_size=None) as socket:
        assert socket.recv(timeout=10.0)


def test_an_agent_is_killed_after_a_question_stays_down_and_comes_back(page: Driven, launched: Launched) -> None:
    page.wait_text("RUNNING", 60.0)
    page.show("Robots")
    page.click_cell("kill 2")
    page.wait_text(r"Kill agent 2\?")
    page.press("Cancel")
    page.until(lambda: "Kill agent 2?" not in page.text(), "the question gone")
    assert launched.state().dismissed == []
    page.click_cell("kill 2")
    page.wait_text(r"Kill agent 2\?")
    page.press("Kill 2")
    page.wait_text(r"R2\s+KILLED")
    page.until(lambda: 2 not in launched.state().live, "agent 2 gone")
    down = launched.state()
    assert down.dismissed == [2]
    page.until(lambda: launched.state().stamp > down.stamp + 0.5, "time going on", 30.0)
    assert launched.state().stopped == [2]
    page.click_cell("restart 2")  # nothing to lose: not asked
    page.wait_text("RUNNING", 30.0)
    page.until(lambda: "KILLED" not in page.text() and launched.state().live == [1, 2], "agent 2 back", 30.0)
    page.show("Live")
    assert page.errors == []


def test_an_agent_that_lives_is_replaced_by_a_fresh_one(page: Driven, launched: Launched) -> None:
    def arrivals() -> int:
        return sum(event.text == "agent 1 is here" for event in launched.state().events)

    page.show("Robots")
    before = arrivals()
    page.click_cell("restart 1")
    page.wait_text(r"Restart agent 1\?")
    page.press("Restart 1")
    page.until(lambda: arrivals() > before and launched.state().dismissed == [], "a fresh agent 1", 30.0)
    page.show("Live")


def test_the_page_returns_to_the_scenario_as_it_was_started(page: Driven, launched: Launched) -> None:
    started = "circle (as started)"
    page.until(lambda: page.chosen("Scenario") == started, "the scenario as it was started is shown")
    page.choose("Scenario", "figure8")
    page.until(lambda: launched.state().scenario == "figure8", "the other scenario runs")
    page.until(lambda: page.chosen("Scenario") == "figure8", "the other scenario is shown")
    page.choose("Scenario", started)
    page.until(lambda: launched.state().scenario == "circle", "the first scenario runs again")
    page.until(lambda: page.chosen("Scenario") == started, "it is shown as what it is")
