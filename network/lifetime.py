"""When a process of a run ends: on SIGTERM, on Ctrl-C if it was started by hand, or when its launcher has exited."""

import os
import signal
import threading
import time
from collections.abc import Callable
from multiprocessing import parent_process
from multiprocessing.connection import wait

TERMINATED = 143
"""Exit code, as shells have it, of a process that SIGTERM ended before its time."""
ENDINGS = {signal.SIGTERM, signal.SIGINT}
MOST_HEARD = 4096
"""Signals that are read from the pipe at once."""
GRACE_SECONDS = 3.0
"""Longest time from the launcher's exit to this process's [s]."""


class Lifetime:
    """Signals a process's loop when to end."""

    def __init__(self, on_end: Callable[[], None] = lambda: None) -> None:
        """Install the handlers; call from the main thread.

        Args:
            on_end: called when the end is due, in a thread of its own: wake the loop here.
        """
        self._over = False
        self._on_end = on_end
        parent = parent_process()
        # Python runs a handler once the main thread is back from what it waits for, and a signal that comes just before
        # it begins to wait interrupts nothing. So the handlers do nothing, and a thread reads from a pipe what came.
        signals, heard = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        signal.set_wakeup_fd(heard)
        signal.signal(signal.SIGTERM, _heed)
        # Ctrl-C reaches every process of a terminal: the launcher then ends its children in order.
        signal.signal(signal.SIGINT, _heed if parent is None else signal.SIG_IGN)
        self._launcher = [] if parent is None else [parent.sentinel]
        threading.Thread(target=self._watch, args=(signals,), daemon=True).start()

    @property
    def over(self) -> bool:
        """Whether to end now."""
        return self._over

    @property
    def abandoned(self) -> bool:
        """Whether the launcher has exited."""
        return bool(self._launcher) and bool(wait(self._launcher, timeout=0.0))

    def _watch(self, signals: int) -> None:
        """Wait for the first signal or the launcher's end; and after the latter, end the process if it does not end."""
        while signals in wait([signals, *self._launcher]) and not ENDINGS & set(os.read(signals, MOST_HEARD)):
            pass  # another signal, for which somebody has a handler
        self._over = True
        self._on_end()
        if self._launcher:
            wait(self._launcher)
            time.sleep(GRACE_SECONDS)
            os._exit(1)


def _heed(*_: object) -> None:
    """Not the end of the process, as without a handler."""
