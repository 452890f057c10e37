"""Who may open the page: this machine's own browsers, or whoever has the token.

On loopback the browser's headers decide: requests must name this machine as their host, and web sockets must come
from this page. On any other host everybody can reach the port, and only a browser with the token's cookie is
admitted. The first visit brings the token in the address, is answered with the cookie, and is redirected to an address
without the token. Nothing is encrypted.
"""

import contextlib
import hmac
import os
import re
import secrets
import socket
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlencode, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Response

from dashboard.theme.templates import render
from formation.errors import EchelonError

LOOPBACK = ("127.0.0.1", "::1", "localhost")
IN_CONTAINER = "ECHELON_IN_CONTAINER"
"""Environment variable that allows another host without a token: the container publishes its port on loopback only."""
TOKEN = "ECHELON_TOKEN"
"""Environment variable with the token; everybody on a machine can read command lines."""
_TOKEN_PATTERN = re.compile(r"[A-Za-z0-9_-]{16,128}")


def new_token() -> str:
    """A random token of 128 bits."""
    return secrets.token_urlsafe(16)


def checked_token(text: str) -> str:
    """The token. Raises EchelonError if it could be guessed, or cannot stand in an address."""
    if not _TOKEN_PATTERN.fullmatch(text):
        raise EchelonError(
            f"--token (or ${TOKEN}): expected 16 to 128 letters, digits, '-' and '_'; got {len(text)} characters. "
            "One that will do: python3 -c 'import secrets; print(secrets.token_urlsafe())'"
        )
    return text


def given_token(option: str | None) -> str | None:
    """The token of the command line, or else of the environment. Raises EchelonError if it could be guessed."""
    text = option if option is not None else os.environ.get(TOKEN) or None
    return None if text is None else checked_token(text)


@dataclass(frozen=True, slots=True)
class Guard:
    """Admits requests, or answers them."""

    host: str
    """Host that the server listens on."""
    token: str | None = None

    def __post_init__(self) -> None:
        """Refuse to serve others than this machine without a token. Raises EchelonError."""
        if self.host not in LOOPBACK and self.token is None and os.environ.get(IN_CONTAINER) != "1":
            raise EchelonError(
                f"--host: expected one of {', '.join(LOOPBACK)}, or a token beside it (--token or ${TOKEN}), because "
                f"anybody who reaches the page controls the run; got {self.host!r} and no token. "
                "Nothing is encrypted; a tunnel is: ssh -L 8090:127.0.0.1:8090 HOST"
            )

    def address(self, port: int) -> str:
        """Address to open: under a host name that is admitted, and with the token."""
        host = self.host
        if self.token is None:  # a container listens on all of its own addresses, and publishes the port on loopback
            host = host if host in LOOPBACK else LOOPBACK[0]
        elif host in ("0.0.0.0", "::"):
            host = socket.gethostname()
        end = "" if self.token is None else f"/?token={self.token}"
        return f"http://[{host}]:{port}{end}" if ":" in host else f"http://{host}:{port}{end}"

    def answer(self, path: str, headers: Headers, port: int) -> Response | None:
        """The answer to a request that is not admitted; None if it is.

        Args:
            path: of the request, with its query.
            headers: of the request.
            port: that the server listens on; two runs on one host have two cookies.
        """
        return _own_pages_only(headers) if self.token is None else self._holders_only(path, headers, port)

    def _holders_only(self, path: str, headers: Headers, port: int) -> Response | None:
        assert self.token is not None
        web_socket = headers.get("Upgrade", "").lower() == "websocket"
        hosts = headers.get_all("Host")
        # Behind a proxy that encrypts, the page's own origin is https.
        own = [f"{scheme}://{host.lower()}" for host in hosts for scheme in ("http", "https")]
        origins = headers.get_all("Origin")
        if web_socket and (len(hosts) != 1 or len(origins) != 1 or origins[0].lower() not in own):
            return _plain(403, "Forbidden", "expected this page's own origin")
        if any(self._is_token(found) for found in _cookies(headers, _cookie_name(port))):
            return _without_token(path) if "token" in _query(path) and not web_socket else None
        if web_socket:
            return _plain(401, "Unauthorized", "expected the token's cookie")
        offered = _query(path).get("token")
        if offered is not None and self._is_token(offered):
            found = _without_token(path)
            found.headers["Set-Cookie"] = _set_cookie(_cookie_name(port), self.token)
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

    def _is_token(self, offered: str) -> bool:
        return self.token is not None and hmac.compare_digest(offered.encode(errors="replace"), self.token.encode())


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
    cookie = SimpleCookie({name: value})
    for attribute, given in (("httponly", True), ("samesite", "Strict"), ("path", "/")):
        cookie[name][attribute] = given
    return str(cookie[name].OutputString())


def _query(path: str) -> dict[str, str]:
    return dict(parse_qsl(urlsplit(path).query, keep_blank_values=True))


def _without_token(path: str) -> Response:
    """Redirect to the same page under an address without the token."""
    rest = urlencode({key: value for key, value in _query(path).items() if key != "token"})
    found = _plain(303, "See Other", "")
    found.headers["Location"] = f"/?{rest}" if rest else "/"
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
        return _plain(403, "Forbidden", "expected the host 127.0.0.1 or localhost")
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
