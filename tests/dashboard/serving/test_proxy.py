"""Laws of a page behind a reverse proxy that gives it a path prefix."""

import asyncio
import re
from collections.abc import Iterator
from http.cookiejar import CookieJar
from urllib.parse import urljoin
from urllib.request import HTTPCookieProcessor, ProxyHandler, build_opener

import pytest
import viser
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from dashboard.serving import server
from dashboard.serving.access import Guard
from dashboard.serving.front_page import LINE
from tests.dashboard.serving.proxy import proxied

SECRET = "a-token_of-some-length"


@pytest.fixture(scope="module")
def origin() -> Iterator[str]:
    """Of a proxy that serves a page below /echelon/."""
    served = server.serve(Guard("127.0.0.1", SECRET), 0, "test")
    with proxied(served.get_port(), "/echelon") as port:
        yield f"http://127.0.0.1:{port}"
    server.stop(served)


def visited(origin: str) -> tuple[str, str, CookieJar]:
    """Address and HTML after a first visit with the token, and the cookies that it left."""
    jar = CookieJar()
    with build_opener(ProxyHandler({}), HTTPCookieProcessor(jar)).open(
        f"{origin}/echelon/?token={SECRET}&fixedDpr=1", timeout=20
    ) as found:
        return found.url, found.read().decode(), jar


def test_the_first_visit_stays_within_the_prefix_and_so_does_its_cookie(origin: str) -> None:
    url, html, jar = visited(origin)
    assert url == f"{origin}/echelon/?fixedDpr=1"
    assert [cookie.path for cookie in jar] == ["/echelon"]
    assert html.index("<head>" + LINE) < html.index("</head>")
    assert not re.findall(r"""(?:src|href|action)=["']/""", html.partition("<body")[0]), "links from the root"


@pytest.mark.parametrize("with_cookie", [True, False])
def test_a_web_socket_within_the_prefix_gets_the_page_if_it_has_the_cookie(origin: str, with_cookie: bool) -> None:
    url, _, jar = visited(origin)
    headers = {"Cookie": "; ".join(f"{cookie.name}={cookie.value}" for cookie in jar)} if with_cookie else {}

    async def first() -> bytes | str:
        async with connect(
            urljoin(url, "index.html").replace("http", "ws", 1),
            origin=origin,  # type: ignore[arg-type]
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            additional_headers=headers,
            max_size=None,
            proxy=None,
        ) as page:
            return await asyncio.wait_for(page.recv(), 20.0)

    if with_cookie:
        assert len(asyncio.run(first())) > 0
    else:
        with pytest.raises(InvalidStatus, match="401"):
            asyncio.run(first())
