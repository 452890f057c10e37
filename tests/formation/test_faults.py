"""Faults in words."""

from formation.faults import PRESETS, Fault


def test_a_distribution_stands_with_its_jitter() -> None:
    assert PRESETS["congested"].words().startswith("latency 150 ms, jitter 100 ms (pareto), loss 5 %, ")
    assert Fault().words() == "healthy"
    assert Fault(jitter=0.1, loss=0.5).words() == "jitter 100 ms, loss 50 %"
