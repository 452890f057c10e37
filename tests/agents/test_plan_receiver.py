"""Laws of a link's counts: what the real network loses is counted by the numbers of plans, whatever was not sent."""

from hypothesis import given
from hypothesis import strategies as st

from agents.plan_receiver import PlanReceiver
from formation.scenario.files import load
from tests import builders

SCENARIO = load("triangle-circle")


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=2, max_size=60))
def test_lost_are_the_plans_that_were_sent_and_did_not_come(ticks: list[tuple[bool, bool]]) -> None:
    receiver = PlanReceiver(SCENARIO, 1, 2)
    number = 0
    arrived: list[int] = []
    for seq, (sent, lost) in enumerate(ticks):
        if sent and not lost:
            receiver.push(builders.plan(1, seq, number=number))
            arrived.append(number)
        number += sent
    counts = receiver.counts()
    expected = arrived[-1] - arrived[0] + 1 if arrived else 0
    assert counts.sent == expected
    assert counts.lost == expected - len(arrived)
    assert counts.sent + counts.duplicated == counts.delivered + counts.lost + counts.in_flight


def test_a_sender_that_begins_anew_or_lies_has_lost_no_more_than_there_were_ticks() -> None:
    receiver = PlanReceiver(SCENARIO, 1, 2)
    for seq, number in ((10, 10), (11, 0), (15, 2**62)):
        receiver.push(builders.plan(1, seq, number=number))
    assert receiver.counts().lost == 3
