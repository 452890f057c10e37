"""Errors that may come hundreds of times a second: each is counted, one a second per subject is logged."""

import logging
from time import monotonic

LOG_INTERVAL = 1.0
"""Between two lines about one subject, at least [s]."""
MAX_SUBJECTS = 1000
"""Subjects that are counted separately, so that a flood of invented keys does not fill the memory."""

_log = logging.getLogger("echelon")


class ThrottledLog:
    """The count, and the log."""

    def __init__(self) -> None:
        self.count = 0
        self._logged: dict[str, tuple[float, int]] = {}
        """Of each subject: when it was logged, and how often it has come since."""

    def add(self, key: str, reason: object) -> None:
        """Note a payload that came on `key` and was not a valid message."""
        skipped = self._due(key)
        if skipped is not None:
            _log.warning("rejected a payload on %.120s: %s%s", key, reason, _more(skipped))

    def add_exception(self, doing: str) -> None:
        """Note the exception that is being handled, and that must not end a loop; `doing` is e.g. "drawing a frame"."""
        skipped = self._due(doing)
        if skipped is not None:
            _log.exception("error while %s; going on%s", doing, _more(skipped))

    def _due(self, subject: str) -> int | None:
        """How many were skipped since the last line about this subject; None if this one is to be skipped too."""
        self.count += 1
        if subject not in self._logged and len(self._logged) >= MAX_SUBJECTS:
            subject = "other keys"
        at, skipped = self._logged.get(subject, (-LOG_INTERVAL, 0))
        now = monotonic()
        if now - at < LOG_INTERVAL:
            self._logged[subject] = (at, skipped + 1)
            return None
        self._logged[subject] = (now, 0)
        return skipped


def _more(skipped: int) -> str:
    return f" (and {skipped} more since the last line)" if skipped else ""
