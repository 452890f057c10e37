"""Laws of who is let in to the page."""

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.datastructures import Headers

from dashboard.serving.access import IN_CONTAINER, TOKEN, Guard, checked_token, given_token, new_token
from dashboard.serving.admission import answer as answer_to
from formation.errors import EchelonError

ROOT = Path(__file__).parents[3]
HERE = Guard("127.0.0.1")
SECRET = "a-token_of-some-length"
HELD = Guard("0.0.0.0", SECRET)
COOKIE = f"echelon-8090={SECRET}"


def asked(host: str = "lab:8090", *, cookie: str | None = None, origin: str | None = None, **more: str) -> Headers:
    headers = Headers({"Host": host, **more})
    for name, value in (("Cookie", cookie), ("Origin", origin)):
        if value is not None:
            headers[name] = value
    return headers


@pytest.mark.parametrize(
    ("host", "origin", "ok"),
    [
        ("127.0.0.1:8090", "http://127.0.0.1:8090", True),
        ("localhost:8090", "http://localhost:8090", True),
        ("127.0.0.1:8090", "http://localhost:8090", False),
        ("127.0.0.1:8090", "http://evil.example", False),
        ("127.0.0.1:8090", "https://127.0.0.1:8090", False),
        ("127.0.0.1:8090", None, False),
        ("evil.example:8090", "http://evil.example:8090", False),
        ("127.0.0.1.evil.example:8090", "http://127.0.0.1.evil.example:8090", False),
    ],
)
def test_only_this_machines_own_pages_may_connect(host: str, origin: str | None, ok: bool) -> None:
    assert (answer_to(HERE, "/", asked(host, origin=origin, Upgrade="websocket"), 8090) is None) == ok


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.2", "::", "lab"])
def test_other_hosts_than_loopback_demand_a_token(host: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(IN_CONTAINER, raising=False)
    with pytest.raises(EchelonError, match=r"--host: expected one of 127\.0\.0\.1.*, or a token beside it"):
        Guard(host)
    Guard(host, new_token())


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.0.0.1", "http://127.0.0.1:8090"),
        ("localhost", "http://localhost:8090"),
        ("::1", "http://[::1]:8090"),
        ("0.0.0.0", "http://127.0.0.1:8090"),
        ("172.17.0.2", "http://127.0.0.1:8090"),
    ],
)
def test_the_address_that_is_printed_is_one_that_is_let_in(
    host: str, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(IN_CONTAINER, "1")
    guard = Guard(host)
    assert guard.address(8090) == address
    assert answer_to(guard, "/", asked(address.removeprefix("http://")), 8090) is None


def test_the_first_visit_takes_a_cookie_and_loses_the_token() -> None:
    address = Guard("192.168.1.2", SECRET).address(8090)
    assert address == f"http://192.168.1.2:8090/?token={SECRET}"
    answer = answer_to(HELD, f"/?fixedDpr=1&token={SECRET}", asked(), 8090)
    assert answer is not None
    assert (answer.status_code, answer.headers["Location"]) == (303, "./?fixedDpr=1")
    cookie = answer.headers["Set-Cookie"]
    assert cookie.startswith(f"{COOKIE};")
    assert set(cookie.split("; ")[1:]) == {"HttpOnly", "SameSite=Strict"}
    assert answer_to(HELD, "/?fixedDpr=1", asked(cookie=cookie.split(";")[0]), 8090) is None
    again = answer_to(HELD, f"/?token={SECRET}", asked(cookie=COOKIE), 8090)
    assert again is not None
    assert again.headers["Location"] == "./"


@pytest.mark.parametrize(
    "path", ["/", "/index.html", "/?token=", "/?token=wrong", "/?token=\udcff", "/?Token=" + SECRET]
)
@pytest.mark.parametrize(
    "cookie", [None, "", "echelon-8090=", "echelon-8090=wrong", f"echelon-8091={SECRET}", f"x={SECRET}", SECRET]
)
def test_without_the_token_there_is_a_page_that_says_so(path: str, cookie: str | None) -> None:
    answer = answer_to(HELD, path, asked(cookie=cookie), 8090)
    assert answer is not None
    assert answer.status_code == 401
    assert "echelon status" in answer.body.decode()
    assert "Set-Cookie" not in answer.headers
    assert SECRET not in answer.body.decode()


@pytest.mark.parametrize(
    ("origin", "cookie", "code"),
    [
        ("http://lab:8090", COOKIE, None),
        ("https://lab:8090", COOKIE, None),  # behind a proxy that encrypts
        ("http://lab:8090", f"theme=dark; {COOKIE}; odd thing", None),
        ("http://lab:8090", None, 401),
        ("http://lab:8090", "echelon-8090=wrong", 401),
        ("http://evil.example", COOKIE, 403),
        ("null", COOKIE, 403),
        (None, COOKIE, 403),
    ],
)
def test_a_web_socket_needs_the_cookie_and_this_pages_origin(
    origin: str | None, cookie: str | None, code: int | None
) -> None:
    headers = asked(origin=origin, cookie=cookie, Upgrade="websocket")
    answer = answer_to(HELD, "/", headers, 8090)
    assert (None if answer is None else answer.status_code) == code
    with_token = answer_to(HELD, f"/?token={SECRET}", headers, 8090)
    assert (None if with_token is None else with_token.status_code) == code, (
        "a web socket brings no token but the cookie"
    )


def test_a_link_on_another_site_leads_in_after_a_reload() -> None:
    """A strict cookie does not come along then, and the page that says so loads itself once more."""
    linked = answer_to(HELD, "/", asked(**{"Sec-Fetch-Site": "cross-site"}), 8090)
    reloaded = answer_to(HELD, "/", asked(**{"Sec-Fetch-Site": "same-origin"}), 8090)
    assert linked is not None
    assert reloaded is not None
    assert "refresh" in linked.body.decode()
    assert "refresh" not in reloaded.body.decode()


@given(st.text(max_size=40), st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=40))
def test_nothing_but_the_token_opens_the_door(path: str, cookie: str) -> None:
    answer = answer_to(HELD, f"/?{path}", asked(cookie=cookie), 8090)
    assert SECRET in path + cookie or (answer is not None and answer.status_code == 401)


@pytest.mark.parametrize(
    "text", ["", "short", "fifteen-letters", "x" * 129, "with a space in it", "umläute-sind-keine"]
)
def test_a_token_that_could_be_guessed_is_refused(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(EchelonError, match="expected 16 to 128 letters"):
        checked_token(text)
    if text:
        monkeypatch.setenv(TOKEN, text)
        with pytest.raises(EchelonError, match=TOKEN):
            given_token(None)


def test_the_environment_gives_the_token_unless_the_command_line_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN, SECRET)
    assert given_token(None) == SECRET
    assert given_token("another-token-of-16") == "another-token-of-16"
    monkeypatch.setenv(TOKEN, "")
    assert given_token(None) is None


def test_no_two_tokens_are_alike() -> None:
    assert len({checked_token(new_token()) for _ in range(100)}) == 100


@pytest.mark.parametrize(("host", "token"), [("0.0.0.0", None), ("0.0.0.0", "short"), ("127.0.0.1", "short")])
def test_a_process_without_a_good_token_does_not_start(host: str, token: str | None) -> None:
    command = [sys.executable, "-m", "dashboard", "--run", "x", "--connect", "unixsock-stream/x", "--host", host]
    command += ["--port", "0"] + ([] if token is None else ["--token", token])
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "token" in done.stderr


@pytest.mark.parametrize("other", ['a={"x": 1}', "a=[1,2", "=", "bad name=1", 'q="', "a=b=c", "é=1"])
def test_a_malformed_cookie_of_another_server_does_not_hide_the_tokens(other: str) -> None:
    for cookies in (f"{other}; {COOKIE}", f"{COOKIE}; {other}"):
        assert answer_to(HELD, "/", asked(cookie=cookies), 8090) is None
    assert answer_to(HELD, "/", asked(cookie=other), 8090) is not None
