"""Who may see the page: this machine's own browsers, or whoever holds the token.

On loopback the guard is the browser's: requests must come under a name of this machine, and web sockets from this
page. On any other host everybody can reach the port, and only a browser with the token's cookie is let in. The first
visit brings the token in the address, takes the cookie, and loses the token from the address bar. Nothing is encrypted.
"""

import hmac
import os
import re
import secrets
import socket
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlencode, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Response

from formation.errors import EchelonError

LOOPBACK = ("127.0.0.1", "::1", "localhost")
IN_CONTAINER = "ECHELON_IN_CONTAINER"
"""Environment variable that allows another host without a token: the container publishes its port on loopback only."""
TOKEN = "ECHELON_TOKEN"
"""Environment variable with the token; the command line can be read by everybody on a machine."""
_SHAPE = re.compile(r"[A-Za-z0-9_-]{16,128}")
_DENIED = """<!doctype html><meta charset="utf-8"><title>Echelon: token needed</title>{head}
<body style="font:16px/1.5 system-ui,sans-serif;max-width:34em;margin:12vh auto;padding:0 1em">
<h1 style="font-size:1.3em">{title}</h1><p>{text}</p>
<p>Open the address that <code>echelon up</code> printed, or that <code>echelon status</code> prints on that machine:
it ends in <code>?token=…</code>. Your browser then remembers it until it is closed.</p>"""


def new_token() -> str:
    """A token that nobody guesses: 128 bits."""
    return secrets.token_urlsafe(16)


def checked_token(text: str) -> str:
    """The token. Raises EchelonError if it could be guessed, or cannot stand in an address."""
    if not _SHAPE.fullmatch(text):
        raise EchelonError(
            f"--token (or ${TOKEN}): expected 16 to 128 letters, digits, '-' and '_'; got {len(text)} characters. "
            "One that will do: python3 -c 'import secrets; print(secrets.token_urlsafe())'"
        )
    return text


def given_token(option: str | None) -> str | None:
    """The token of the command line or else of the environment. Raises EchelonError if it will not do."""
    text = option if option is not None else os.environ.get(TOKEN) or None
    return None if text is None else checked_token(text)


@dataclass(frozen=True, slots=True)
class Guard:
    """Lets requests in, or answers them."""

    host: str
    """That is listened on."""
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
        """Where a person finds the page: under a name that is let in, and with the token."""
        host = self.host
        if self.token is None:  # a container listens on all of its own addresses, and publishes the port on loopback
            host = host if host in LOOPBACK else LOOPBACK[0]
        elif host in ("0.0.0.0", "::"):
            host = socket.gethostname()
        end = "" if self.token is None else f"/?token={self.token}"
        return f"http://[{host}]:{port}{end}" if ":" in host else f"http://{host}:{port}{end}"

    def answer(self, path: str, headers: Headers, port: int) -> Response | None:
        """What a request gets instead of the page; None if it is let in.

        Args:
            path: of the request, with its query.
            headers: of the request.
            port: that is listened on; two runs on one host keep two cookies.
        """
        return _own_pages_only(headers) if self.token is None else self._holders_only(path, headers, port)

    def _holders_only(self, path: str, headers: Headers, port: int) -> Response | None:
        assert self.token is not None
        socket_wanted = headers.get("Upgrade", "").lower() == "websocket"
        hosts = headers.get_all("Host")
        # Behind a proxy that encrypts, the page's own origin is https.
        own = [f"{scheme}://{host.lower()}" for host in hosts for scheme in ("http", "https")]
        origins = headers.get_all("Origin")
        if socket_wanted and (len(hosts) != 1 or len(origins) != 1 or origins[0].lower() not in own):
            return _plain(403, "Forbidden", "expected this page's own origin")
        if any(self._right(found) for found in _cookies(headers, _cookie_name(port))):
            return _without_token(path) if "token" in _query(path) and not socket_wanted else None
        if socket_wanted:
            return _plain(401, "Unauthorized", "expected the token's cookie")
        offered = _query(path).get("token")
        if offered is not None and self._right(offered):
            found = _without_token(path)
            found.headers["Set-Cookie"] = f"{_cookie_name(port)}={self.token}; HttpOnly; SameSite=Strict; Path=/"
            return found
        title, text = "This page needs its token", "Whoever sees this page controls the robots, so it asks for a token."
        if offered is not None:
            title, text = "That is not the token", "It may be that of an earlier run: a new one is drawn for each."
        # A strict cookie does not come along when another site's link led here; a reload by this very page brings it.
        linked = headers.get("Sec-Fetch-Site") == "cross-site"
        head = '<meta http-equiv="refresh" content="0">' if linked and offered is None else ""
        return _html(401, "Unauthorized", _DENIED.format(head=head, title=title, text=text))

    def _right(self, offered: str) -> bool:
        return self.token is not None and hmac.compare_digest(offered.encode(errors="replace"), self.token.encode())


def _cookie_name(port: int) -> str:
    return f"echelon-{port}"


def _cookies(headers: Headers, name: str) -> list[str]:
    pairs = [pair.strip().partition("=") for line in headers.get_all("Cookie") for pair in line.split(";")]
    return [value for key, _, value in pairs if key == name]


def _query(path: str) -> dict[str, str]:
    return dict(parse_qsl(urlsplit(path).query, keep_blank_values=True))


def _without_token(path: str) -> Response:
    """To the same page, under an address that can be shown."""
    rest = urlencode({key: value for key, value in _query(path).items() if key != "token"})
    found = _plain(303, "See Other", "")
    found.headers["Location"] = f"/?{rest}" if rest else "/"
    return found


def _own_pages_only(headers: Headers) -> Response | None:
    """403 for a request that comes from another site's page, or under a name that is not this machine's.

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
