"""The wall clock of a run: when the next tick is due, the real pace, the wall time of the episode."""

from collections import deque
from time import monotonic

CATCH_UP_SECONDS = 0.2
"""A delay beyond this is not made up for [s]."""


class Rate:
    """Keeps `speed` simulated seconds per second; 0 means as fast as possible."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.overruns = 0
        """Ticks that began more than a tick late."""
        self._due = monotonic()
        self._seen: deque[tuple[float, float]] = deque()
        self._began = self._ended = 0.0

    @property
    def left(self) -> float:
        """Wall-clock time until the next tick is due [s]; not positive if it is."""
        return self._due - monotonic() if self.speed else 0.0

    @property
    def wall(self) -> float:
        """Wall-clock time from the episode's first tick to its newest [s]."""
        return self._ended - self._began

    def hold(self) -> None:
        """Simulated time stands still: forget the schedule, so that no tick is made up for later."""
        self._due = monotonic()

    def begin(self, k: int) -> None:
        """Note that tick k is sent."""
        if k == 0:
            self._began = monotonic()

    def end(self) -> None:
        """Note that the tick is complete."""
        self._ended = monotonic()

    def next(self, interval: float) -> None:
        """The next tick is due one `interval` of simulated time [s] after this one."""
        if self.speed:
            self._due = max(self._due + interval / self.speed, monotonic() - CATCH_UP_SECONDS)

    def note_overrun(self, interval: float) -> None:
        """Count the tick if it begins more than its own length late."""
        if self.speed and -self.left > interval / self.speed:
            self.overruns += 1

    def measured(self, simulated: float) -> float:
        """Simulated seconds per second over about the last second; call it often.

        Args:
            simulated: simulated time now [s].
        """
        at = monotonic()
        if self._seen and simulated < self._seen[-1][1]:
            self._seen.clear()  # reset
        self._seen.append((at, simulated))
        while len(self._seen) > 2 and self._seen[0][0] < at - 1.0:
            self._seen.popleft()
        began, first = self._seen[0]
        return (simulated - first) / (at - began) if at > began else 0.0
