"""Which moment the page shows: the present, or a place on the tape that users choose and that may play on from there.

All pages of a run show the same moment, because they share one scene.
"""

import math
from collections.abc import Sequence

from dashboard.telemetry.tape import Place, Tape

SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
MOST_STEP = 3600.0
"""Of one step of the playhead [s]."""


class Playhead:
    """The moment that is shown, moved by what pages tell."""

    def __init__(self, tape: Tape, *, live: bool = True) -> None:
        """At the present, or at the beginning of a tape that has none.

        Args:
            tape: that it moves on.
            live: whether there is a present to return to.
        """
        self._tape, self.live = tape, live
        self._place: Place | None = None if live else Place(0, 0.0)
        self.playing = not live
        self.speed = 1.0
        self.loop = False
        self._at = 0.0

    def tell(self, words: Sequence[str]) -> bool:
        """Do what a page tells: "go", "step", "mark", "play", "speed", "loop", "live"; returns whether it was that."""
        match words:
            case ["live"]:
                self._place, self.playing = (None, False) if self.live else (self._place, self.playing)
            case ["go", episode, stamp]:
                number, at = _number(episode), _number(stamp)
                if number is not None and at is not None:
                    self.go(Place(int(number), at))
            case ["step", text]:
                seconds = _number(text)
                if seconds is not None:
                    self._step(min(max(seconds, -MOST_STEP), MOST_STEP))
            case ["mark", way] if way in ("next", "back"):
                here = self._place or self._newest()
                place = self._tape.mark_after(here, back=way == "back") if here is not None else None
                if place is not None:
                    self.go(place)
            case ["play"]:
                if self._place is None:
                    self._place = self._newest()
                else:
                    self.playing = not self.playing
            case ["speed", text]:
                speed = _number(text)
                self.speed = speed if speed in SPEEDS else self.speed
            case ["loop"]:
                self.loop = not self.loop
            case _:
                return False
        return True

    def go_in_run(self, episode: int, stamp: float) -> None:
        """Show a moment [s] of the run's own episode of this number; nothing, if that is not kept."""
        numbers = [one.number for one in self._tape.episodes if one.run_number == episode]
        if numbers:
            self.go(Place(numbers[-1], stamp))

    def go(self, place: Place) -> None:
        """Show a place on the tape."""
        self._place = self._tape.nearest(place)
        self.playing = False

    def _newest(self) -> Place | None:
        episodes = self._tape.episodes
        return Place(episodes[-1].number, episodes[-1].ends) if episodes else None

    def _step(self, seconds: float) -> None:
        """Move on, over the border of an episode if need be."""
        here = self._place or self._newest()
        episode = self._tape.episode(here.episode) if here is not None else None
        if here is None or episode is None:
            return
        stamp, numbers = here.stamp + seconds, [one.number for one in self._tape.episodes]
        other = numbers.index(here.episode) + (1 if seconds > 0.0 else -1)
        over = stamp > episode.ends if seconds > 0.0 else stamp < episode.begins
        if over and 0 <= other < len(numbers) and here.stamp in (episode.begins, episode.ends):
            beside = self._tape.episodes[other]
            self.go(Place(beside.number, beside.begins if seconds > 0.0 else beside.ends))
        else:
            self.go(Place(here.episode, stamp))

    def place(self, now: float) -> Place | None:
        """The place to show at a time of the wall clock [s]; None for the present."""
        passed, self._at = now - self._at, now
        if self._place is None:
            return None
        found = self._tape.nearest(self._place)
        episode = self._tape.episode(found.episode) if found is not None else None
        if found is None or episode is None:
            return None
        if self.playing:
            found = Place(found.episode, found.stamp + self.speed * min(passed, 1.0))
            if found.stamp >= episode.ends:
                found = self._end(found, episode.ends)
        self._place = found
        return found

    def _end(self, place: Place, ends: float) -> Place:
        """Where to go on at the end of an episode: in the next one, from the start, or nowhere."""
        later = [one for one in self._tape.episodes if one.number > place.episode]
        if later:
            return Place(later[0].number, later[0].begins)
        if self.loop:
            first = self._tape.episodes[0]
            return Place(first.number, first.begins)
        self.playing = self.playing and self.live  # a run goes on; a record has come to its end
        return Place(place.episode, ends)


def _number(text: str) -> float | None:
    """A finite number that a page wrote."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and abs(value) < 1e9 else None
