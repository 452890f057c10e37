"""A session of its own on somebody's ROS 2: a client of their router, never a part of a run's bus.

With a peer session, messages would not pass through a plain router. Apart from network/zenoh_bus.py, this is the only
module that imports zenoh.
"""

import secrets
import struct
from collections.abc import Callable
from time import monotonic, time_ns
from types import TracebackType
from typing import Self

import zenoh

from formation.errors import EchelonError
from network.zenoh_bus import client_config, close_session
from ros import tokens
from ros.tokens import DEFAULT_QOS, Endpoint
from ros.types import HASHES

PATIENCE = 2.0
"""Longest wait for a router [s]."""
MAX_MESSAGE = 1 << 20
"""A longer message is not read [bytes]."""
_ATTACHMENT = struct.Struct("<qqB16s")
"""Of every message: its number, the time [ns since the epoch], the length of what follows, and who publishes."""


class RosPublisher:
    """Publishes on one topic, as a publisher of ROS 2 does."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._publisher = session.declare_publisher(key, congestion_control=zenoh.CongestionControl.DROP, express=True)
        self._gid = secrets.token_bytes(16)
        self._count = 0

    def put(self, data: bytes) -> None:
        """Publish a message."""
        self._count += 1
        attachment = _ATTACHMENT.pack(self._count, time_ns(), len(self._gid), self._gid)
        self._publisher.put(data, attachment=attachment)


class RosSession:
    """A node on a router of ROS 2. Use as a context manager."""

    def __init__(self, endpoint: str, node: str, *, domain: int = 0, patience: float = PATIENCE) -> None:
        """Connect; waits at most so long for the router [s].

        Args:
            endpoint: of their router.
            node: its name in ROS 2.
            domain: ROS_DOMAIN_ID.
            patience: longest wait [s].

        Raises:
            EchelonError: the router cannot be reached.
        """
        try:
            self._session = zenoh.open(client_config(endpoint, patience=patience))
        except zenoh.ZError as error:
            if "endpoint" in str(error).lower() and "connect" not in str(error).lower():
                raise EchelonError(f"expected an endpoint such as tcp/10.0.0.11:7447; got {endpoint!r}") from None
            raise EchelonError(f"expected a router of ROS 2 at {endpoint}; nobody answers there") from None
        self._node, self._domain = node, domain
        self._zid = str(self._session.info.zid())
        self._kept: list[object] = []
        self._entities = 0

    @property
    def connected(self) -> bool:
        """Whether there is a link to their router now."""
        return bool(self._session.info.routers_zid())

    def tokens(self, seconds: float = 1.0) -> list[str]:
        """Every token that stands; waits at most so long for them [s]."""
        replies = self._session.liveliness().get(tokens.ALL, timeout=seconds)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok]

    def publisher(self, topic: str, kind: str, type_hash: str = "") -> RosPublisher:
        """A publisher that ROS 2 sees; the hash is that of Iron and newer, unless it is given."""
        mine = Endpoint(self._domain, "MP", "/", self._node, topic, kind, type_hash or HASHES[kind], DEFAULT_QOS)
        self._show(mine)
        return RosPublisher(self._session, mine.key)

    def subscribe(self, theirs: Endpoint, take: Callable[[bytes, float], None]) -> Callable[[], None]:
        """Subscribe to a publisher of theirs.

        Args:
            theirs: as their token says.
            take: called in a thread of Zenoh's with the bytes of a message and when it came in [s, monotonic].

        Returns:
            Ends it.
        """

        def arrived(sample: zenoh.Sample) -> None:
            if len(sample.payload) <= MAX_MESSAGE:
                take(bytes(sample.payload.to_bytes()), monotonic())

        callback = zenoh.handlers.Callback(arrived, indirect=False)
        subscriber = self._session.declare_subscriber(theirs.any_hash, callback)
        self._show(theirs._replace(kind="MS", namespace="/", node=self._node, qos=DEFAULT_QOS))
        return subscriber.undeclare

    def _show(self, endpoint: Endpoint) -> None:
        """Declare the tokens by which nodes of ROS 2 know of an endpoint."""
        liveliness = self._session.liveliness()
        if not self._entities:
            self._kept.append(liveliness.declare_token(tokens.node_token(self._domain, self._zid, self._node)))
        self._entities += 1
        self._kept.append(liveliness.declare_token(tokens.write(endpoint, self._zid, self._entities)))

    def close(self) -> None:
        """Leave their network."""
        close_session(self._session)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
