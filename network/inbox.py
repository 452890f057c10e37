"""A queue that any thread adds to, and one thread reads.

It stands for queue.SimpleQueue, whose `get` with a time limit may never return: if the reader loses its processor just
before it begins to wait, for longer than the limit, the time left is negative, and that means without a limit (seen
with CPython 3.11 and 3.12). A process then sleeps until something comes in: an agent alone in a run, or a world that
shared its process with its agents, for good.
"""

import contextlib
from collections import deque
from queue import Empty
from threading import Lock
from time import monotonic
from typing import Generic, TypeVar

T = TypeVar("T")


class Inbox(Generic[T]):
    """First in, first out; to add never waits, also in a signal handler."""

    def __init__(self) -> None:
        self._items: deque[T] = deque()
        self._bell = Lock()
        """Held while nothing has come in since the reader last waited."""
        self._bell.acquire()

    def put(self, item: T) -> None:
        """Add an item, and wake the reader if it waits."""
        self._items.append(item)
        if self._bell.locked():
            with contextlib.suppress(RuntimeError):  # another thread was first
                self._bell.release()

    def __len__(self) -> int:
        return len(self._items)

    def empty(self) -> bool:
        """Whether nothing is there."""
        return not self._items

    def get_nowait(self) -> T:
        """The oldest item. Raises queue.Empty if there is none."""
        try:
            return self._items.popleft()
        except IndexError:
            raise Empty from None

    def get(self, timeout: float | None = None) -> T:
        """The oldest item; if there is none, wait for one, at most so long [s]. Raises queue.Empty after that."""
        until = None if timeout is None else monotonic() + timeout
        while not self._items:  # the bell may have been rung for items that are gone
            if until is None:
                self._bell.acquire()
            elif not self._bell.acquire(timeout=max(0.0, until - monotonic())) and not self._items:
                raise Empty
        return self._items.popleft()
