"""Progress of a batch of trials: a bar with the time left on a terminal, a line now and then elsewhere."""

import sys
import time
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from cli.options import tell

PLAIN_SECONDS = 20.0
"""Between the lines that report progress where there is no terminal."""
WHOLE = 1_000_000
"""Steps of the progress bar."""


class TrialProgress:
    """The bar of one command."""

    def __init__(self, name: str, cores: int | None) -> None:
        """A bar that stands still.

        Args:
            name: in front of it.
            cores: how many work; None if nobody here knows.
        """
        self._cores = cores
        self._terminal = sys.stderr.isatty()
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[done]} {task.fields[noun]}{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not self._terminal,
        )
        self._task = self._bar.add_task(name, total=WHOLE, done="0", noun="trials", rate="")
        self._began: tuple[float, float, int] | None = None
        self._told = time.monotonic()

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._bar.stop()
        if kind is KeyboardInterrupt:
            tell("interrupted; the same command goes on where it stopped")

    def trials(self, share: float, done: int, total: int, fresh: bool) -> None:
        """So many trials are done.

        Args:
            share: of the work, 0 to 1; trials of many robots count more.
            done: trials.
            total: trials.
            fresh: whether this one was simulated just now; else it was found in the journal.
        """
        now = time.monotonic()
        rate = self._rate(done, now)
        self._bar.update(self._task, completed=share * WHOLE, done=f"{done}/{total}", rate=rate)
        if self._began is None or not fresh:
            self._began = (now, share, done)  # what is found in the journal does not count as speed
            self._bar.reset(self._task, completed=round(share * WHOLE), done=f"{done}/{total}")
            return
        if not self._terminal and now - self._told >= PLAIN_SECONDS and share > self._began[1]:
            self._told = now
            left = (1.0 - share) * (now - self._began[0]) / (share - self._began[1])
            tell(f"{done} of {total} trials{rate}, about {_duration(left)} left")

    def _rate(self, done: int, now: float) -> str:
        """Trials a second per core since the first that was simulated; empty while that is unknown."""
        if self._began is None or self._cores is None or now <= self._began[0] or done <= self._began[2]:
            return ""
        return f", {(done - self._began[2]) / (now - self._began[0]) / self._cores:.2g} a second per core"

    def figures(self, done: int, total: int) -> None:
        """So many figures are drawn."""
        self._bar.update(self._task, completed=WHOLE * done / total, done=f"{done}/{total}", noun="figures", rate="")


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
