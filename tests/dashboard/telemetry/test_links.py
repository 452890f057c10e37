"""Laws of a link's health."""

from dashboard.telemetry.links import LOST_SECONDS, LinkView, ring_links
from network.messages import LinkCounts
from tests.builders import state, status


def test_a_link_is_lost_when_it_is_cut_or_old_or_its_receiver_silent() -> None:
    now = state(stamp=1.0, faults={"1->2": {"cut": True}})
    said = {2: status(2, 1, age=0.1), 3: status(3, 2, age=LOST_SECONDS + 0.1), 1: status(1, 3, age=0.01)}
    assert [view.label for view in ring_links(now, said)] == ["CUT", "LOST", "OK"]
    assert [view.lost for view in ring_links(state(stamp=3.0), said)] == [True, True, True]
    assert [view.age for view in ring_links(state(episode=1), said)] == [None, None, None]


def test_loss_is_the_share_of_plans_sent_that_were_lost() -> None:
    assert LinkView(1, 2, 0.0, {}, LinkCounts(sent=10, lost=3)).loss == 0.3
    assert LinkView(1, 2, 0.0, {}, LinkCounts()).loss == 0.0
