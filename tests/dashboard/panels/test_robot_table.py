"""Laws of the robot table."""

from dashboard.page import Page
from dashboard.panels.robot_table import robot_table
from dashboard.panels.run_summary import condition
from network import topics
from network.bus import Sample
from network.codec import encode
from tests.builders import state, status
from tests.dashboard.fakes import receive


def test_a_robot_that_waits_is_shown_with_its_lag(page: Page) -> None:
    for message in (status(1, 3), status(2, 1, lag=1.26)):
        page._feed.source._waiting.put(Sample(topics.status("x", message.sender), encode(message)))  # type: ignore[attr-defined]
    snapshot, links, *_ = page._feed.now()
    assert "1.3 s behind the clock" in condition(snapshot).note
    rows = robot_table(snapshot, links, page._clickable).split("<tr")
    assert ["−1.3 s" in row for row in rows[2:]] == [False, True, False]


def test_a_robot_whose_solver_fails_is_marked(page: Page) -> None:
    for message in (status(1, 3), status(2, 1, converged=False)):
        page._feed.source._waiting.put(Sample(topics.status("x", message.sender), encode(message)))  # type: ignore[attr-defined]
    snapshot, links, *_ = page._feed.now()
    rows = robot_table(snapshot, links, page._clickable).split("<tr")
    assert ["NO SOLUTION" in row.split("</table>")[0] for row in rows[2:]] == [False, True, False]


def test_the_page_draws_a_closed_ring_and_who_left_it_can_join(page: Page) -> None:
    now = state(seq=2, stamp=2.0, away=[2])
    assert receive(page._feed.source, topics.state("x"), encode(now))
    page._frame()  # with every panel, plot and layer
    assert page._errors.count == 0
    snapshot, links, *_ = page._feed.now()
    assert [str(link.id) for link in links] == ["1->3", "3->1"]
    rows = robot_table(snapshot, links, page._clickable).split("<tr")[2:]
    assert ['data-cell="join' in row for row in rows] == [False, True, False]
    assert ['data-cell="leave' in row for row in rows] == [True, False, True]
    assert page._feed.export_buffer.data() is not None
