"""viser's HTML, with a line before its program that lets the page stand behind a proxy's path prefix.

viser's program opens the web socket at the address of the page without its last slash. Behind a proxy that serves the
page as http://HOST/PREFIX/, that address is outside of what the proxy forwards. The line gives the page its name
within the prefix, index.html, so that the web socket has it too.
"""

import gzip
from functools import lru_cache
from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Response

PATHS = ("/", "/index.html")
LINE = (
    '<script>if (location.pathname.length > 1 && location.pathname.endsWith("/")) '
    'history.replaceState(null, "", "index.html" + location.search + location.hash);</script>'
)


def with_prefix(path: str, answer: Response | None) -> Response | None:
    """The answer of viser's server to a request for `path`, with the line if it is the page."""
    if answer is None or answer.status_code != HTTPStatus.OK or path.partition("?")[0] not in PATHS:
        return answer
    body = _with_line(bytes(answer.body), zipped=answer.headers.get("Content-Encoding") == "gzip")
    headers = Headers(answer.headers)
    del headers["Content-Length"]
    headers["Content-Length"] = str(len(body))
    return Response(answer.status_code, answer.reason_phrase, headers, body)


@lru_cache(maxsize=4)
def _with_line(body: bytes, *, zipped: bool) -> bytes:
    """The body with the line at the begin of its head."""
    html = gzip.decompress(body) if zipped else body
    made = html.replace(b"<head>", b"<head>" + LINE.encode(), 1)
    return gzip.compress(made) if zipped else made
