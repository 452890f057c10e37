"""What ends a launcher: Ctrl-C and its kind become KeyboardInterrupt, and wait while it tidies up."""

import signal
import threading
from typing import Any

_ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def _ignored() -> set[signal.Signals]:
    """Of nohup, which wants the run to outlive its terminal."""
    return {number for number in (signal.SIGHUP,) if signal.getsignal(number) is signal.SIG_IGN}


class Endings:
    """The handlers of a launcher's process."""

    def __init__(self) -> None:
        self._handlers: dict[signal.Signals, Any] = {}

    def begin(self) -> None:
        """From now on they interrupt; also Ctrl-C, which a shell has ignored by what it starts in the background."""
        if threading.current_thread() is threading.main_thread():  # elsewhere Python allows no handlers
            endings = [number for number in _ENDINGS if number not in _ignored()]
            self._handlers = {number: signal.signal(number, _interrupt) for number in endings}

    def ignore(self) -> None:
        """From now on they do nothing: a second Ctrl-C must not interrupt the tidying up."""
        for number in self._handlers:
            signal.signal(number, signal.SIG_IGN)

    def end(self) -> None:
        """As before `begin`."""
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
