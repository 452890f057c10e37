"""The pace of a run: when the next tick is due, the real pace, the wall time of the episode.

It reads no clock: `now` is monotonic wall-clock time [s] everywhere.
"""

from collections import deque

CATCH_UP_SECONDS = 0.2
"""A delay beyond this is not made up for [s]."""
STANDSTILL_SECONDS = 0.5
"""Between two looks of a world that runs, at most [s]: a longer gap is time in which the world itself stood still."""


class RunningTime:
    """Time for which this process has run [s]: without gaps in which it was suspended, or had no processor."""

    def __init__(self) -> None:
        self.now = 0.0
        self._looked_at: float | None = None

    def look(self, now: float) -> float:
        """It is `now` by the wall clock; returns how long the process has stood still since the last look [s]."""
        gap = 0.0 if self._looked_at is None else now - self._looked_at
        self._looked_at = now
        if gap > STANDSTILL_SECONDS:
            return gap
        self.now += gap
        return 0.0


class Rate:
    """Keeps `speed` simulated seconds per second; 0 means as fast as possible."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.overruns = 0
        """Ticks that began more than a tick late."""
        self._due = 0.0
        self._seen: deque[tuple[float, float]] = deque()
        self._began = self._ended = 0.0

    def left(self, now: float) -> float:
        """Wall-clock time until the next tick is due [s]; not positive if it is."""
        return self._due - now if self.speed else 0.0

    @property
    def wall(self) -> float:
        """Wall-clock time from the episode's first tick to its newest [s]."""
        return self._ended - self._began

    def hold(self, now: float) -> None:
        """Simulated time stands still: forget the schedule, so that no tick is made up for later."""
        self._due = now

    def begin(self, k: int, now: float) -> None:
        """Note that tick k is sent."""
        if k == 0:
            self._began = now

    def end(self, now: float) -> None:
        """Note that the tick is complete."""
        self._ended = now

    def next(self, interval: float, now: float) -> None:
        """The next tick is due one `interval` of simulated time [s] after this one."""
        if self.speed:
            self._due = max(self._due + interval / self.speed, now - CATCH_UP_SECONDS)

    def note_overrun(self, interval: float, now: float) -> None:
        """Count the tick if it begins more than its own length late."""
        if self.speed and -self.left(now) > interval / self.speed:
            self.overruns += 1

    def measured(self, simulated: float, now: float) -> float:
        """Simulated seconds per second over about the last second; call it often.

        Args:
            simulated: simulated time now [s].
            now: wall-clock time [s].
        """
        if self._seen and simulated < self._seen[-1][1]:
            self._seen.clear()  # reset
        self._seen.append((now, simulated))
        while len(self._seen) > 2 and self._seen[0][0] < now - 1.0:
            self._seen.popleft()
        began, first = self._seen[0]
        return (simulated - first) / (now - began) if now > began else 0.0
