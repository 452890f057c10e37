"""Laws of the link matrix: every link of the ring once, its health in a word, and the target marked."""

import re
from unittest.mock import MagicMock

import pytest

from dashboard.panels.clickable import Clickable
from dashboard.panels.link_matrix import MATRIX_ROBOTS, MOST, link_matrix
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.snapshot import Snapshot
from formation.faults import Fault
from formation.link_ids import LinkId
from tests.builders import state, status


def matrix(robots: int, target: tuple[str, ...] = ("all",), **changes: object) -> str:
    now = state(robots, **changes)  # type: ignore[arg-type]
    statuses = {i: status(i, (i - 2) % robots + 1, age=0.05) for i in range(1, robots + 1)}
    clickable = Clickable(MagicMock(), lambda *_: None)
    clickable.set_verbs({"all": 0, "link": robots, "both": robots})
    snapshot = Snapshot(now, None, statuses, now.poses, now.stamp, (), world_alive=True, connected=True)
    return link_matrix(snapshot, ring_links(now, statuses), clickable, target)


@pytest.mark.parametrize("robots", [2, 3, MATRIX_ROBOTS, MATRIX_ROBOTS + 1, 40])
def test_every_link_of_the_ring_is_there_once_and_can_be_clicked(robots: int) -> None:
    html = matrix(robots)
    assert re.findall(r'data-cell="link (\d+)"', html) == [str(i) for i in range(1, robots + 1)]
    assert html.count("50 ms") == robots


def test_of_a_crowd_the_worst_links_are_listed_and_the_others_counted() -> None:
    cut = LinkId(700, 701)
    html = matrix(1000, faults={cut: Fault(cut=True)})
    assert len(re.findall(r'data-cell="link', html)) == MOST
    assert "CUT <span>50 ms</span>" in html
    assert f"{1000 - MOST} more links" in html


def test_a_cut_link_says_so() -> None:
    html = matrix(3, faults={LinkId(1, 2): Fault(cut=True)})
    assert html.count("CUT <span>50 ms</span>") == 1


def test_the_target_is_marked() -> None:
    assert matrix(3).count("e-target") == 1
    assert matrix(3, ("2->3",)).count("e-target") == 1
    assert matrix(3, ("1->2", "2->3")).count("e-target") == 3, "both links and their robot"
    assert matrix(3, ()).count("e-target") == 0
