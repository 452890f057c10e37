"""Laws of a link's health."""

from dashboard.telemetry.links import LOST_SECONDS, LinkView, ring_links
from formation.faults import Fault
from formation.link_ids import LinkId
from network.values import LinkCounts
from tests.builders import state, status


def test_a_link_is_lost_when_it_is_cut_or_old_or_its_receiver_silent() -> None:
    now = state(stamp=1.0, faults={LinkId(1, 2): Fault(cut=True)})
    statuses = {2: status(2, 1, age=0.1), 3: status(3, 2, age=LOST_SECONDS + 0.1), 1: status(1, 3, age=0.01)}
    assert [link.label for link in ring_links(now, statuses)] == ["CUT", "LOST", "OK"]
    assert [link.lost for link in ring_links(state(stamp=3.0), statuses)] == [True, True, True]
    assert [link.age for link in ring_links(state(episode=1), statuses)] == [None, None, None]


def test_loss_is_the_share_of_plans_sent_that_were_lost() -> None:
    assert LinkView(LinkId(1, 2), 0.0, Fault(), LinkCounts(sent=10, lost=3)).loss == 0.3
    assert LinkView(LinkId(1, 2), 0.0, Fault(), LinkCounts()).loss == 0.0
