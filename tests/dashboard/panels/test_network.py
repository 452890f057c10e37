"""Laws of the Network tab: ages and counts of the last minute, and beliefs' errors, of now and of then."""

import re

import numpy as np
import pytest

from dashboard.page import Page
from dashboard.panels.network import CARDS, SHORTEST, NetworkTab
from dashboard.panels.network import _bars as bars
from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.feed import Feed
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.origin import HERE
from dashboard.telemetry.tape import Place
from formation.scenario.files import load
from network.values import LinkCounts
from tests.builders import motion, state, status


def filled(feed: Feed, robots: int, seconds: float) -> None:
    """A run in which the link 1->2 is late from 100 s on and loses every second plan."""
    scenario = load("ring-16") if robots == 16 else load("triangle-circle")
    for tick in range(round(seconds / 0.1)):
        stamp = 0.1 * tick
        late = stamp >= 100.0
        counts = LinkCounts(sent=tick, delivered=tick, lost=max(0, (tick - 1000) // 2), in_flight=3)
        held = motion(begins=stamp)
        age = 0.4 if late else 0.02
        message = status(2, 1, stamp=stamp, age=age, counts=counts, plan=motion(), believes=held)
        belief = BeliefView(2, 1, np.zeros(3), np.zeros((21, 2)), np.array([0.03, 0.04]))
        feed.tape.add(state(robots, stamp=stamp), scenario, {2: message}, [belief], None, HERE)


def text(html: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", html))


@pytest.mark.parametrize(
    ("stamp", "age", "lost", "most"), [(90.0, "20 ms", "lost 0", "20 ms"), (190.0, "400 ms", "lost 300", "400 ms")]
)
def test_a_card_has_the_last_minute_before_the_moment(page: Page, stamp: float, age: str, lost: str, most: str) -> None:
    feed = page._feed
    filled(feed, 3, 200.0)
    feed.playhead.go(Place(feed.tape.episodes[-1].number, stamp))
    view = feed.shown(feed.now())
    html = text(NetworkTab(feed).html(view, page._clickable, ()))
    card = html.split("1 → 2")[1].split("2 → 3")[0]
    assert age in card
    assert "sent 600 delivered 600" in card
    assert lost in card
    assert "in flight 3" in card
    assert f"95 %: {most}" in card
    assert "belief off by 50 mm" in card


def test_every_age_has_a_bar_also_the_shortest_in_single_precision(page: Page) -> None:
    feed, shortest = page._feed, status(2, 1, age=SHORTEST)
    feed.tape.add(state(3, stamp=1.0), load("triangle-circle"), {2: shortest}, [], None, HERE)
    ages, _, _ = feed.tape.links(Place(feed.tape.episodes[-1].number, 1.0), 60.0)
    known = ages[:, 1][np.isfinite(ages[:, 1])]
    assert [height for _, height, _ in bars(known)] == [1.0]


def test_of_many_links_the_worst_are_shown(page: Page) -> None:
    feed = page._feed
    filled(feed, 16, 120.0)
    now = state(16, stamp=119.9)
    view = feed.now()._replace(place=Place(feed.tape.episodes[-1].number, 119.9), links=ring_links(now, {}))
    view = view._replace(snapshot=feed.tape.moment(view.place).snapshot)  # type: ignore[union-attr, arg-type]
    html = NetworkTab(feed).html(view, page._clickable, ())
    assert html.count("e-network-card") == CARDS
    assert "4 more links" in html
