"""What a test sees of a run beside its page, over one session: to open one takes longer than to ask."""

from typing import Self

from network import topics
from network.bus import Sample
from network.codec import decode
from network.control import Operation
from network.messages import Ghost, State
from network.zenoh_bus import ZenohBus


class Watch:
    """A client of the run's router, which it connects to when it is first asked."""

    def __init__(self, endpoint: str, run: str) -> None:
        self._endpoint, self._run = endpoint, run
        self._bus: ZenohBus | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the session."""
        if self._bus is not None:
            self._bus.__exit__(None, None, None)
            self._bus = None

    def _session(self) -> ZenohBus:
        if self._bus is None:
            self._bus = ZenohBus(self._endpoint, self._run)
            self._bus.subscribe(topics.state(self._run))
            self._bus.subscribe(topics.ghost(self._run))
        return self._bus

    def _next(self, topic: str, seconds: float) -> bytes:
        """The next message on a topic; what has come before is forgotten."""
        session = self._session()
        while not session.inbox.empty():
            session.inbox.get_nowait()
        for item in session.incoming(seconds):
            if isinstance(item, Sample) and item.key == topic:
                return item.payload
        raise TimeoutError(f"expected a message of {topic} within {seconds:g} s")

    def state(self, seconds: float = 10.0) -> State:
        """The next state."""
        return decode(State, self._next(topics.state(self._run), seconds))

    def ghost(self, seconds: float = 10.0) -> Ghost:
        """The next message of the ghost."""
        return decode(Ghost, self._next(topics.ghost(self._run), seconds))

    def ask(self, operation: Operation) -> None:
        """Request an operation of the world, as another page would."""
        reply = self._session().ask(operation, timeout=10.0)
        assert reply is not None
        assert reply.ok, reply.reason
