"""Laws of a lossy network in real time: UDP loses what the model does; over TCP no formation breaks down."""

import pytest

from benchmarks.loss import LOSSY, Result, measure, model
from tests.exceptions import needs

pytestmark = pytest.mark.processes
LOSS, SECONDS, TRIES = 20, 4.0, 3


def is_like_the_model(result: Result) -> bool:
    expected = model(LOSS)
    return all(
        abs(result.age[link][n] - expected[link][n]) <= 0.1 * expected[link][n] for link in LOSSY for n in (0, 1)
    )


def test_over_udp_plans_are_as_old_as_the_models_and_losses_are_counted() -> None:
    needs("network namespaces", "nftables")
    results: list[Result] = []
    while not any(map(is_like_the_model, results)) and len(results) < TRIES:  # a busy machine delays plans as well
        results.append(measure("udp", LOSS, SECONDS))
    assert is_like_the_model(results[-1]), results
    assert all(0.1 < results[-1].lost[link] < 0.3 for link in LOSSY)
    assert results[-1].whole_after is not None


@pytest.mark.parametrize("transport", ["quic", "tcp"])
def test_encrypted_a_formation_lasts(transport: str) -> None:
    needs("network namespaces", "nftables")
    result = measure(transport, LOSS, SECONDS)
    assert result.whole_after is not None, result
    assert result.age["1->2"][0] < 0.05  # of the link that loses nothing
