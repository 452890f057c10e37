"""Laws of a lossy network in real time; how old plans get is a matter of the clock, and of `benchmarks/loss.py`."""

import pytest

from benchmarks.loss import LOSSY, measure
from tests.exceptions import needs

pytestmark = pytest.mark.processes
LOSS, SECONDS = 20, 4.0


def test_over_udp_what_the_network_loses_is_counted() -> None:
    needs("network namespaces", "nftables")
    result = measure("udp", LOSS, SECONDS)
    assert all(0.1 < result.lost[link] < 0.35 for link in LOSSY), result
    assert result.whole_after is not None, result


def test_encrypted_a_formation_lasts() -> None:
    needs("network namespaces", "nftables")
    result = measure("tcp", LOSS, SECONDS)
    assert result.whole_after is not None, result
