"""Who may open the page: this machine's own browsers, or whoever has the token.

On loopback the browser's headers decide; on any other host everybody can reach the port, and only a browser with the
token is admitted (dashboard/serving/admission.py). Nothing is encrypted.
"""

import hmac
import os
import re
import secrets
import socket
from dataclasses import dataclass

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
    """Who is admitted to a page."""

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

    def is_token(self, offered: str) -> bool:
        """Whether it is the token; takes as long whatever is offered."""
        return self.token is not None and hmac.compare_digest(offered.encode(errors="replace"), self.token.encode())
