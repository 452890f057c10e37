"""Payloads that were not valid messages: counted, and logged at most once a second per sender."""

import logging
from time import monotonic

LOG_INTERVAL = 1.0
MAX_SENDERS = 1000
"""Keys that are logged separately, so that a flood of invented keys does not fill the memory."""

_log = logging.getLogger("echelon")


class ThrottledLog:
    """The count, and the log."""

    def __init__(self) -> None:
        self.count = 0
        self._logged: dict[str, tuple[float, int]] = {}

    def add(self, key: str, reason: object) -> None:
        """Note a payload that came on `key`."""
        self.count += 1
        if key not in self._logged and len(self._logged) >= MAX_SENDERS:
            key = "other keys"
        at, silent = self._logged.get(key, (-LOG_INTERVAL, 0))
        now = monotonic()
        if now - at < LOG_INTERVAL:
            self._logged[key] = (at, silent + 1)
            return
        self._logged[key] = (now, 0)
        more = f" (and {silent} more since)" if silent else ""
        _log.warning("rejected a payload on %.120s: %s%s", key, reason, more)
