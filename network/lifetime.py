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
GRACE_SECONDS = 3.0
"""Longest time from the launcher's exit to this process's [s]."""


class Lifetime:
    """Signals a process's loop when to end."""

    def __init__(self, on_end: Callable[[], None] = lambda: None) -> None:
        """Install the handlers; call from the main thread.

        Args:
            on_end: called when the end is due, in a signal handler: wake the loop here.
        """
        self._over = False
        self._on_end = on_end
        signal.signal(signal.SIGTERM, self._end)
        parent = parent_process()
        # Ctrl-C reaches every process of a terminal: the launcher then ends its children in order.
        signal.signal(signal.SIGINT, self._end if parent is None else signal.SIG_IGN)
        if parent is not None:
            threading.Thread(target=self._outlive, args=(parent.sentinel,), daemon=True).start()

    @property
    def over(self) -> bool:
        """Whether to end now."""
        return self._over

    def _end(self, *_: object) -> None:
        self._over = True
        self._on_end()

    def _outlive(self, launcher: int) -> None:
        wait([launcher])
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(GRACE_SECONDS)
        os._exit(1)
