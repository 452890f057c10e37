"""The Network tab: a card per link with ages and counts of the last minute, and the error of the receiver's belief."""

import math
from collections.abc import Collection
from time import monotonic
from typing import NamedTuple

import numpy as np

from dashboard.panels.clickable import Clickable
from dashboard.telemetry.feed import Feed, View
from dashboard.telemetry.links import LOST_SECONDS, LinkView
from dashboard.telemetry.tape import Place
from dashboard.theme.formatting import duration, error
from dashboard.theme.limits import DISTANCE_LIMIT
from dashboard.theme.palette import hue
from dashboard.theme.templates import render
from formation.arrays import FloatArray
from network.messages import State
from network.values import LinkCounts

SECONDS = 60.0
"""That a card looks back [s]."""
SHORTEST, LONGEST = 0.01, 3.0
"""Ends of the axis of ages, which is logarithmic [s]."""
BINS = 32
SPARKS = 60
"""Points of the line of ages."""
CARDS = 12
"""With more links the worst are shown."""
INTERVAL = 0.8
"""Between two updates [s]: each draws a picture per link."""
COUNTED = ("sent", "delivered", "lost", "late", "in_flight")


class Card(NamedTuple):
    """One link."""

    link: LinkView
    hues: tuple[str, str]
    """Of sender and receiver."""
    age: str
    word: str
    """Its health."""
    bars: list[tuple[float, float, float]]
    """Left edge, height (both 0 to 1) and health level of each bar that is not empty."""
    most: float | None
    """Where 95 % of the ages are below, 0 to 1 along the axis."""
    most_age: str
    sparks: str
    """Points of the line of ages, for SVG: 100 wide, 12 high."""
    counts: dict[str, int]
    """Of the last minute."""
    off: str
    """Error of the receiver's belief."""
    off_level: float
    rate: str
    """Of the plans sent, in kB/s; empty if unknown."""


class NetworkTab:
    """Draws the cards now and then."""

    def __init__(self, feed: Feed) -> None:
        self._feed = feed
        self._sizes: dict[int, int] = {}
        """Of the newest plan of each robot on the wire [bytes]."""
        self._drawn: tuple[float, object, str] = (0.0, None, "")

    def html(self, view: View, clickable: Clickable, target: Collection[str]) -> str:
        """The cards of the moment that is looked at, the worst first if there are many."""
        key = (view.place, tuple(target))
        if key == self._drawn[1] and monotonic() - self._drawn[0] < INTERVAL:
            return self._drawn[2]
        state, place = view.snapshot.state, self._place(view)
        if state is None or place is None:
            return ""
        ages, counts, seconds = self._feed.tape.links(place, SECONDS)
        links = view.links
        if len(links) > CARDS:
            links = sorted(links, key=lambda link: (-link.level, -(link.age or 0.0)))[:CARDS]
        if view.place is None:
            self._weigh(view, {link.sender for link in links})
        offs = {belief.receiver: (belief.error, view.snapshot.noise) for belief in view.beliefs}
        cards = [self._card(state, link, ages, counts, seconds, offs) for link in links]
        html = render(
            "panels/network.html",
            cards=cards,
            left_out=len(view.links) - len(cards),
            limit=_along(LOST_SECONDS),
            clickable=clickable,
            target=target,
        )
        self._drawn = monotonic(), key, html
        return html

    def _place(self, view: View) -> Place | None:
        if view.place is not None:
            return view.place
        episodes = self._feed.tape.episodes
        return Place(episodes[-1].number, episodes[-1].ends) if episodes else None

    def _weigh(self, view: View, senders: Collection[int]) -> None:
        for robot, status in view.snapshot.statuses.items():
            if status.plan_bytes and robot in senders:
                self._sizes[robot] = status.plan_bytes

    def _card(
        self,
        state: State,
        link: LinkView,
        ages: FloatArray,
        counts: dict[int, LinkCounts],
        seconds: float,
        offs: dict[int, tuple[float, float]],
    ) -> Card:
        n, known = len(state.poses), ages[:, link.receiver - 1]
        known = known[np.isfinite(known)]
        found = counts.get(link.receiver, LinkCounts())
        off, size = offs.get(link.receiver), self._sizes.get(link.sender)
        most = float(np.quantile(known, 0.95)) if len(known) else None
        word = link.label.lower() if link.label != "OK" else "fresh"
        return Card(
            link=link,
            hues=(hue(link.sender, n), hue(link.receiver, n)),
            age="·" if link.age is None else " ".join(duration(link.age)),
            word={"stale": "late"}.get(word, word),
            bars=_bars(known),
            most=None if most is None else _along(most),
            most_age="" if most is None else " ".join(duration(most)),
            sparks=_sparks(known),
            counts={name.replace("_", " "): getattr(found, name) for name in COUNTED},
            off="·" if off is None else " ".join(error(*off)).rstrip(),
            off_level=0.0 if off is None else off[0] / DISTANCE_LIMIT,
            rate="" if size is None or seconds < 1.0 else f"{1e-3 * size * found.sent / seconds:.1f} kB/s",
        )


def _along(age: float) -> float:
    """Where an age is on the axis, 0 to 1."""
    share = math.log(min(max(age, SHORTEST), LONGEST) / SHORTEST)
    return share / math.log(LONGEST / SHORTEST)


def _bars(ages: FloatArray) -> list[tuple[float, float, float]]:
    """A histogram of ages over the axis."""
    if not len(ages):
        return []
    edges = SHORTEST * (LONGEST / SHORTEST) ** np.linspace(0.0, 1.0, BINS + 1)
    found, _ = np.histogram(np.clip(ages, SHORTEST, 0.999 * LONGEST), edges)
    middles = np.sqrt(edges[:-1] * edges[1:]) / LOST_SECONDS
    rows = zip(range(BINS), found / found.max(), middles, strict=True)
    return [(i / BINS, float(height), min(float(level), 1.0)) for i, height, level in rows if height > 0.0]


def _sparks(ages: FloatArray) -> str:
    """The ages over time, the newest on the right."""
    every = max(1, len(ages) // SPARKS)
    rows = [_along(float(age)) for age in ages[::-1][::every][::-1]]
    step = 100.0 / max(1, len(rows) - 1)
    return " ".join(f"{i * step:.1f},{12.0 * (1.0 - row):.1f}" for i, row in enumerate(rows))
