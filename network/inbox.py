"""A queue that any thread adds to, and one thread reads; it may be woken for several items at once.

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
        """Held while nothing has come in that the reader waits for, since it last waited."""
        self._bell.acquire()
        self._enough, self._loud = 1, False

    def put(self, item: T, *, quietly: bool = False) -> None:
        """Add an item, and wake the reader if it waits; quietly: only if there are as many as it waits for."""
        self._items.append(item)
        if not quietly:
            self._loud = True
        elif len(self._items) < self._enough:
            return
        if self._bell.locked():
            with contextlib.suppress(RuntimeError):  # another thread was first
                self._bell.release()

    def __len__(self) -> int:
        return len(self._items)

    def empty(self) -> bool:
        """Whether nothing is there."""
        return not self._items

    def ready(self, enough: int = 1) -> bool:
        """Whether there is what `get` waits for."""
        return len(self._items) >= (1 if self._loud else enough)

    def get_nowait(self) -> T:
        """The oldest item. Raises queue.Empty if there is none. For what is left nobody waits again."""
        self._loud = False
        try:
            item = self._items.popleft()
        except IndexError:
            raise Empty from None
        if self._items:  # what is left may have been put loudly
            self._loud = True
        return item

    def get(self, timeout: float | None = None, enough: int = 1) -> T:
        """The oldest item, once there are enough.

        Args:
            timeout: longest wait [s]; after it any item is enough.
            enough: for so many that were put quietly the reader is woken, and for any other.

        Raises:
            Empty: there was no item for so long.
        """
        until = None if timeout is None else monotonic() + timeout
        self._enough = enough
        while not self.ready(enough):  # the bell may have been rung for items that are gone
            if until is None:
                self._bell.acquire()
            elif not self._bell.acquire(timeout=max(0.0, until - monotonic())):
                break
        return self.get_nowait()
