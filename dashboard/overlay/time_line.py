"""The time line under the scene: what is kept of the run, its marks and errors, and the moment that is looked at."""

from functools import partial
from time import monotonic
from typing import Any

import viser

from dashboard.keys import bind
from dashboard.overlay.overlay import hidden_part
from dashboard.panels.mirrored_controls import set_if_changed
from dashboard.telemetry.feed import Feed, View
from dashboard.telemetry.marks import Mark
from dashboard.theme.limits import DISTANCE_LIMIT

INTERVAL = 0.5
"""Between two updates of what moves by itself [s]."""
COMMANDS = {
    "Time line: the run as it is": (viser.Icon.BROADCAST, ("live",)),
    "Time line: next event": (viser.Icon.ARROW_BAR_TO_RIGHT, ("mark", "next")),
    "Time line: event before": (viser.Icon.ARROW_BAR_TO_LEFT, ("mark", "back")),
}
"""Their icons, and what the playhead is told."""
MOST_MARKS = 60
"""On the line, the newest."""


class TimeLine:
    """The hidden elements of the time line; overlay/time_line.js draws it."""

    def __init__(self, gui: viser.GuiApi, feed: Feed) -> None:
        """Add them to the current container of the page."""
        self._feed = feed
        self._line: Any = gui.add_html("")
        self._marks: Any = gui.add_html("")
        self._rewound: Any = gui.add_html("")
        self._drawn_at = 0.0
        self._key: object = None
        for name, (icon, words) in COMMANDS.items():
            bind(gui, name, icon, partial(self._tell, words))

    def _tell(self, words: tuple[str, ...], _: object) -> None:
        self._feed.playhead.tell(words)

    def draw(self, live: View, view: View) -> None:
        """Show the present, and the moment that is looked at."""
        playhead, tape = self._feed.playhead, self._feed.tape
        key = (view.place, playhead.playing, playhead.speed, playhead.loop, len(tape.episodes))
        if key == self._key and monotonic() - self._drawn_at < INTERVAL:
            return
        self._key, self._drawn_at = key, monotonic()
        trace = {number: (rows * [1.0, 1e3]).round(1).tolist() for number, rows in tape.trace().items()}
        line = {
            "episodes": [
                [one.number, round(one.begins, 2), round(one.ends, 2), trace[one.number]] for one in tape.episodes
            ],
            "at": view.place,
            "live": playhead.live,
            "playing": playhead.playing,
            "speed": playhead.speed,
            "loop": playhead.loop,
            "limit": 1e3 * DISTANCE_LIMIT,
        }
        set_if_changed(self._line, "content", hidden_part("line", line))
        marks = [[number, mark.kind, mark.stamp, mark.ends, mark.label] for number, mark in tape.marks()[-MOST_MARKS:]]
        set_if_changed(self._marks, "content", hidden_part("marks", marks))
        set_if_changed(self._rewound, "content", hidden_part("rewound", self._banner(live, view)))

    def _banner(self, live: View, view: View) -> dict[str, object] | None:
        """What the banner over a moment of the past reads; none over the present, or a record, which has no other."""
        place = view.place
        if place is None or not self._feed.playhead.live:
            return None
        found = [
            mark for number, mark in self._feed.tape.marks() if number == place.episode and mark.stamp <= place.stamp
        ]
        newest = self._feed.tape.episodes[-1]
        earlier = place.episode != newest.number
        parts = [_after(found[-1], place.stamp)] if found else []
        parts.append("an earlier episode" if earlier else "")
        parts.append(f"the run goes on at {live.snapshot.stamp:.1f} s")
        return {"at": f"{place.stamp:.1f}", "rest": " · ".join(part for part in parts if part)}


def _after(mark: Mark, stamp: float) -> str:
    """The moment by the last mark before it."""
    if mark.ends is not None and mark.ends <= stamp:
        return f"{stamp - mark.ends:.1f} s after {mark.label} was over"
    return f"{stamp - mark.stamp:.1f} s after {mark.label}"
