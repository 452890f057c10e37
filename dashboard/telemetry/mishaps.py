"""Errors of our own that must not end a loop: logged once a second at most."""

import logging
from time import monotonic

LOG_INTERVAL = 1.0

_log = logging.getLogger("echelon")


class Mishaps:
    """What went wrong in one loop."""

    def __init__(self, doing: str) -> None:
        """Log with these words: "drawing a frame"."""
        self._doing = doing
        self._logged_at = -LOG_INTERVAL
        self.count = 0

    def note(self) -> None:
        """Note the exception that is being handled."""
        self.count += 1
        now = monotonic()
        if now - self._logged_at >= LOG_INTERVAL:
            self._logged_at = now
            _log.exception("error number %d while %s; going on", self.count, self._doing)
