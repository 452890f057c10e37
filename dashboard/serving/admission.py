"""Admits the requests of a browser, or answers them itself.

On loopback requests must name this machine as their host, and web sockets must come from this page. Elsewhere only a
browser with the token's cookie is admitted: the first visit brings the token in the address, is answered with the
cookie, and is redirected to an address without the token.
"""

import contextlib
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlencode, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Response

from dashboard.serving.access import Guard
from dashboard.theme.templates import render


def answer(guard: Guard, path: str, headers: Headers, port: int) -> Response | None:
    """The answer to a request that is not admitted; None if it is.

    Args:
        guard: who is admitted.
        path: of the request, with its query.
        headers: of the request.
        port: that the server listens on; two runs on one host have two cookies.
    """
    return _own_pages_only(headers) if guard.token is None else _holders_only(guard, path, headers, port)


def too_many(pages: int) -> Response:
    """The answer to a page that is one too many."""
    return _plain(503, "Service Unavailable", f"expected at most {pages} pages at a time")


def _holders_only(guard: Guard, path: str, headers: Headers, port: int) -> Response | None:
    assert guard.token is not None
    web_socket = headers.get("Upgrade", "").lower() == "websocket"
    hosts = headers.get_all("Host")
    # Behind a proxy that encrypts, the page's own origin is https.
    own = [f"{scheme}://{host.lower()}" for host in hosts for scheme in ("http", "https")]
    origins = headers.get_all("Origin")
    if web_socket and (len(hosts) != 1 or len(origins) != 1 or origins[0].lower() not in own):
        return _plain(403, "Forbidden", "expected this page's own origin")
    if any(guard.is_token(found) for found in _cookies(headers, _cookie_name(port))):
        return _without_token(path) if "token" in _query(path) and not web_socket else None
    if web_socket:
        return _plain(401, "Unauthorized", "expected the token's cookie")
    offered = _query(path).get("token")
    if offered is not None and guard.is_token(offered):
        found = _without_token(path)
        found.headers["Set-Cookie"] = _set_cookie(_cookie_name(port), guard.token)
        return found
    title, text = (
        "This page needs its token",
        "Whoever opens this page controls the robots, so it requires a token.",
    )
    if offered is not None:
        title, text = "That is not the token", "It may be that of an earlier run: every run has a new one."
    # After a link on another site the browser holds back a strict cookie; a reload by this page itself sends it.
    linked = headers.get("Sec-Fetch-Site") == "cross-site"
    page = render("serving/denied.html", reload=linked and offered is None, title=title, text=text)
    return _html(401, "Unauthorized", page)


def _cookie_name(port: int) -> str:
    return f"echelon-{port}"


def _cookies(headers: Headers, name: str) -> list[str]:
    """Values of all cookies of this name."""
    found = []
    for pair in (pair for line in headers.get_all("Cookie") for pair in line.split(";")):
        cookie: SimpleCookie = SimpleCookie()
        with contextlib.suppress(CookieError):  # one by one: a malformed cookie of another server hides the rest
            cookie.load(pair.strip())
        found += [morsel.value for key, morsel in cookie.items() if key == name]
    return found


def _set_cookie(name: str, value: str) -> str:
    """A cookie without a path: it is then for the folder of the page, which may be a proxy's prefix."""
    cookie = SimpleCookie({name: value})
    for attribute, given in (("httponly", True), ("samesite", "Strict")):
        cookie[name][attribute] = given
    return str(cookie[name].OutputString())


def _query(path: str) -> dict[str, str]:
    return dict(parse_qsl(urlsplit(path).query, keep_blank_values=True))


def _without_token(path: str) -> Response:
    """Redirect to the same page under an address without the token: relative, because a proxy may add a prefix."""
    rest = urlencode({key: value for key, value in _query(path).items() if key != "token"})
    found = _plain(303, "See Other", "")
    found.headers["Location"] = f"./?{rest}" if rest else "./"
    return found


def _own_pages_only(headers: Headers) -> Response | None:
    """403 for a request from another site's page, or with a host name that is not this machine's.

    A browser sends the Origin of the page with every web socket. It must be the address that was asked for (Host), and
    that must be loopback: else a page could give its own name our address (DNS rebinding).
    """
    origins, hosts = headers.get_all("Origin"), headers.get_all("Host")
    host = hosts[0].lower() if len(hosts) == 1 else ""
    known = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
    if known not in ("127.0.0.1", "localhost", "[::1]"):
        return _plain(
            403, "Forbidden", "expected the host 127.0.0.1 or localhost; for others, and proxies, start it with --token"
        )
    if headers.get("Upgrade", "").lower() == "websocket" and origins != [f"http://{host}"]:
        return _plain(403, "Forbidden", "expected this page's own origin")
    return None


def _plain(code: int, reason: str, text: str) -> Response:
    return _response(code, reason, "text/plain; charset=utf-8", f"{text}\n")


def _html(code: int, reason: str, text: str) -> Response:
    return _response(code, reason, "text/html; charset=utf-8", text)


def _response(code: int, reason: str, kind: str, text: str) -> Response:
    body = text.encode()
    lines = {"Content-Type": kind, "Content-Length": str(len(body)), "Cache-Control": "no-store"}
    return Response(code, reason, Headers({**lines, "Referrer-Policy": "no-referrer"}), body)
