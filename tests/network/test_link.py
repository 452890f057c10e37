"""Laws of the faulty link: it conserves messages, is never early, and its draws depend on who, whom and which only."""

import math
from collections import Counter
from itertools import groupby
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.errors import WireError
from formation.faults import PRESETS, Fault
from formation.link_ids import LinkId
from network.codec import decode, encode
from network.link import MEMORY, QUEUE_LIMIT, Arrival, Link, damaged
from network.messages import Plan
from network.values import LinkCounts
from tests.builders import plan

TICK = 0.01
SHARE = st.sampled_from([0.0, 0.0, 0.05, 0.3, 0.9, 1.0])
FAULTS = st.builds(
    Fault,
    latency=st.sampled_from([0.0, 0.003, 0.05, 0.6]),
    jitter=st.sampled_from([0.0, 0.01, 0.2]),
    distribution=st.sampled_from(["uniform", "normal", "pareto"]),
    loss=SHARE,
    burst=st.sampled_from([0.0, 1.0, 1.2, 5.0, 20.0]),
    duplicate=SHARE,
    reorder=SHARE,
    keep_order=st.booleans(),
    rate=st.sampled_from([0.0, 0.0, 7.0, 50.0, 99.0]),
    corrupt=SHARE,
    cut=st.sampled_from([False, False, False, True]),
)
PLAN = plan(2, 17, inputs=np.arange(40.0).reshape(20, 2))


def run(link: Link[int], seqs: range | list[int], wait: float = 60.0) -> list[Arrival[int]]:
    """Push every seq at its tick, pop at every tick, and wait for the rest."""
    arrivals = []
    for seq in seqs:
        link.push(seq, seq * TICK, seq)
        arrivals += link.pop(seq * TICK)
    return arrivals + link.pop((seqs[-1] + 1) * TICK + wait)


def fate(arrivals: list[Arrival[int]]) -> Counter[tuple[int, float, float | None]]:
    """What became of each message, whatever the order of popping."""
    return Counter((a.seq, a.due - a.sent, a.damage) for a in arrivals)


def received(fault: Fault, seqs: range | list[int], seed: int = 0) -> set[int]:
    """The seqs that came through."""
    return {a.seq for a in run(Link(seed, LinkId(1, 2), fault), seqs)}


def runs_of_losses(fault: Fault, count: int, seed: int = 0) -> list[int]:
    """Lengths of the runs of lost messages among so many."""
    came = received(fault, range(count), seed)
    return [len(list(group)) for lost, group in groupby(range(count), lambda k: k not in came) if lost]


# ---------------------------------------------------------------- conservation and causality


@given(st.lists(FAULTS, min_size=1, max_size=3), st.integers(0, 2**32), st.data())
@settings(max_examples=100)
def test_sent_and_duplicated_is_delivered_and_lost_and_in_flight_at_any_time(faults: Any, seed: Any, data: Any) -> None:
    link: Link[int] = Link(seed, LinkId(1, 2))
    popped = 0
    for seq in range(data.draw(st.integers(1, 60))):
        if seq % 20 == 0:
            link.fault = faults[seq // 20 % len(faults)]
        link.push(seq, seq * TICK, seq)
        if seq % 3 == 0:
            popped += len(link.pop(seq * TICK))
        c = link.counts
        assert c.sent == seq + 1
        assert c.delivered == popped
        assert c.sent + c.duplicated == c.delivered + c.lost + c.in_flight
    popped += len(link.pop(math.inf))
    c = link.counts
    assert c.in_flight == 0
    assert popped == c.delivered == c.sent + c.duplicated - c.lost


@given(FAULTS, st.integers(0, 2**32))
@settings(max_examples=80)
def test_no_message_is_early_and_none_is_popped_before_it_is_due(fault: Any, seed: Any) -> None:
    link: Link[int] = Link(seed, LinkId(1, 2), fault)
    for seq in range(50):
        now = seq * TICK
        link.push(seq, now, seq)
        for arrival in link.pop(now):
            assert arrival.due >= arrival.sent
            assert arrival.due <= now + 1e-9
    for arrival in link.pop(math.inf):
        assert arrival.due >= arrival.sent
        assert arrival.due > 49 * TICK + 1e-9  # what was due before has been popped before


@given(FAULTS)
@settings(max_examples=40)
def test_arrivals_are_popped_in_the_order_of_their_times(fault: Any) -> None:
    link: Link[int] = Link(3, LinkId(1, 2), fault)
    for seq in range(50):
        link.push(seq, seq * TICK, seq)
    due = [a.due for a in link.pop(math.inf)]
    assert due == sorted(due)


@given(st.sampled_from(["uniform", "normal", "pareto"]), st.floats(0.0, 1.0), st.floats(0.0, 2.0))
def test_no_delay_is_negative_and_pareto_is_never_below_the_latency(
    distribution: Any, latency: Any, jitter: Any
) -> None:
    fault = Fault(latency=latency, jitter=jitter, distribution=distribution)
    arrivals = run(Link(1, LinkId(1, 2), fault), range(40), wait=math.inf)
    assert len(arrivals) == 40
    assert min(a.due - a.sent for a in arrivals) >= 0.0
    if distribution == "pareto":
        assert min(a.due - a.sent for a in arrivals) >= latency - 1e-12


def test_a_message_that_is_due_on_a_tick_comes_on_that_tick_despite_rounding() -> None:
    # 0.1 + 0.2 > 0.3 in binary: a stamp plus a latency may miss the tick's own stamp by a rounding.
    for k in range(1000):
        link: Link[int] = Link(0, LinkId(1, 2), Fault(latency=0.3))
        link.push(k, k * TICK, k)
        assert link.pop((k + 29) * TICK) == []
        assert len(link.pop((k + 30) * TICK)) == 1


# ---------------------------------------------------------------- single faults


def test_a_link_that_leaves_nothing_to_chance_delays_or_cuts() -> None:
    arrivals = run(Link(0, LinkId(1, 2), Fault(latency=0.05)), range(50))
    assert [a.seq for a in arrivals] == list(range(50))
    assert all(a.due == a.sent + 0.05 and a.damage is None for a in arrivals)
    assert not received(Fault(latency=0.05, cut=True), range(50))


@given(st.integers(0, 2**32), st.integers(0, 10**9))
def test_a_perfect_link_is_transparent(seed: Any, seq: Any) -> None:
    link: Link[int] = Link(seed, LinkId(1, 2))
    assert link.transparent
    link.push(seq, 0.3, 7)
    assert link.pop(0.3) == [Arrival(seq, 0.3, 0.3, 7, None)]
    assert link.counts == LinkCounts(sent=1, delivered=1)
    assert link.transparent


def test_a_mended_link_is_transparent_once_the_last_delayed_message_is_out() -> None:
    link: Link[int] = Link(0, LinkId(1, 2), Fault(latency=0.5))
    link.push(0, 0.0, 0)
    link.fault = Fault()
    assert not link.transparent
    link.push(1, 0.01, 1)
    assert [a.seq for a in link.pop(0.01)] == [1]
    assert not link.transparent
    assert [a.seq for a in link.pop(0.5)] == [0]
    assert link.transparent


def test_a_fault_holds_for_messages_pushed_from_then_on() -> None:
    link: Link[int] = Link(0, LinkId(1, 2), Fault(latency=0.5))
    link.push(0, 0.0, 0)
    link.fault = Fault(cut=True)
    link.push(1, 0.01, 1)
    assert [a.seq for a in link.pop(10.0)] == [0]
    assert link.counts.lost == 1


@given(FAULTS)
@settings(max_examples=30)
def test_a_cut_link_loses_all(fault: Any) -> None:
    link: Link[int] = Link(0, LinkId(1, 2), fault.model_copy(update={"cut": True}))
    assert run(link, range(30)) == []
    assert link.counts == LinkCounts(sent=30, lost=30)


def test_loss_of_all_and_of_none() -> None:
    assert received(Fault(loss=1.0), range(200)) == set()
    assert received(Fault(loss=1.0, burst=5), range(200)) == set()
    assert received(Fault(loss=0.0, burst=5), range(200)) == set(range(200))


@given(FAULTS, st.integers(0, 2**32))
@settings(max_examples=60)
def test_a_link_that_keeps_order_never_lets_a_message_overtake(fault: Any, seed: Any) -> None:
    link: Link[int] = Link(seed, LinkId(1, 2), fault.model_copy(update={"keep_order": True, "duplicate": 0.0}))
    seqs = [a.seq for a in run(link, range(60), wait=math.inf)]
    assert seqs == sorted(seqs)


def test_without_keep_order_jitter_reorders() -> None:
    seqs = [a.seq for a in run(Link(0, LinkId(1, 2), Fault(latency=0.1, jitter=0.1)), range(60))]
    assert seqs != sorted(seqs)
    assert sorted(seqs) == list(range(60))


def test_a_share_of_messages_overtakes_the_delay() -> None:
    arrivals = run(Link(0, LinkId(1, 2), Fault(latency=0.1, reorder=0.2)), range(5000))
    skipped = [a for a in arrivals if a.due == a.sent]
    assert all(a.due == pytest.approx(a.sent + 0.1) for a in arrivals if a.due != a.sent)
    assert len(skipped) / 5000 == pytest.approx(0.2, abs=0.02)  # 3.5 standard deviations of a share of 5000


def test_a_rate_limit_spaces_messages_and_loses_what_the_queue_cannot_hold() -> None:
    rate = 20.0
    link: Link[int] = Link(0, LinkId(1, 2), Fault(rate=rate))
    arrivals = run(link, range(500))  # 100 messages a second
    due = [a.due for a in arrivals]
    assert len(due) >= 90
    assert min(np.diff(due)) >= 1.0 / rate - 1e-9
    assert max(a.due - a.sent for a in arrivals) <= QUEUE_LIMIT / rate + 1e-9
    assert max(a.due - a.sent for a in arrivals) >= (QUEUE_LIMIT - 1) / rate
    # 5 s at 20/s pass, with the queue and the first besides
    assert len(due) == pytest.approx(5.0 * rate + QUEUE_LIMIT, abs=2)
    assert link.counts.lost == 500 - len(due)


def test_a_rate_limit_above_the_traffic_does_nothing() -> None:
    arrivals = run(Link(0, LinkId(1, 2), Fault(rate=101.0)), range(200))
    assert [a.due for a in arrivals] == [a.sent for a in arrivals]


def at_rates(rates: dict[int, float], count: int, **keys: Any) -> list[Arrival[int]]:
    """Push so many messages, 100 a second; from these on the link has these rates."""
    link: Link[int] = Link(0, LinkId(1, 2))
    arrivals = []
    for seq in range(count):
        if seq in rates:
            link.fault = Fault(rate=rates[seq], **keys)
        link.push(seq, seq * TICK, seq)
        arrivals += link.pop(seq * TICK)
    return arrivals


def test_a_rate_that_was_low_for_a_while_leaves_nothing_behind() -> None:
    """What waits when it ends drains at the rate that is then, and so does what comes afterwards."""
    arrivals = at_rates({0: 50.0, 100: 0.01, 200: 50.0}, 600)
    due = np.array([a.due for a in arrivals])
    assert np.count_nonzero((due > 1.03) & (due < 1.98)) == 0
    after = due[due > 1.98]
    np.testing.assert_allclose(np.diff(after), 0.02, atol=1e-9)
    assert after[0] == pytest.approx(2.0, abs=1e-9)
    assert len(after) == pytest.approx(4.0 * 50.0, abs=2)
    waited = [a for a in arrivals if a.due > 1.98 and a.sent < 1.98]
    assert len(waited) == pytest.approx(QUEUE_LIMIT, abs=1)


@pytest.mark.parametrize("unlimited", [0.0, 1e6])
def test_once_a_rate_limit_is_lifted_all_that_waits_comes_at_once(unlimited: float) -> None:
    arrivals = at_rates({0: 10.0, 100: unlimited}, 110)
    waited = [a.due for a in arrivals if a.due > 0.985 and a.sent < 0.985]
    assert len(waited) == QUEUE_LIMIT
    np.testing.assert_allclose(waited, 1.0, atol=1e-4)
    assert [a.due for a in arrivals if a.seq >= 102] == [pytest.approx(seq * TICK) for seq in range(102, 110)]


def test_a_link_that_was_perfect_meanwhile_begins_its_rate_anew() -> None:
    link: Link[int] = Link(0, LinkId(1, 2), Fault(rate=0.01))
    link.push(0, 0.0, 0)
    assert [a.due for a in link.pop(0.0)] == [0.0]
    link.fault = Fault()
    assert link.transparent
    link.fault = Fault(rate=0.01)
    link.push(500, 5.0, 500)
    assert [a.due for a in link.pop(5.0)] == [5.0]


def test_a_rate_that_falls_holds_for_those_that_wait_too() -> None:
    arrivals = at_rates({0: 50.0, 100: 5.0}, 300)
    due = np.array([a.due for a in arrivals])
    np.testing.assert_allclose(np.diff(due[due > 1.02]), 0.2, atol=1e-9)


def test_a_change_of_other_keys_moves_nothing_that_waits() -> None:
    whole, link = run(Link(0, LinkId(1, 2), Fault(rate=7.0)), range(100)), Link[int](0, LinkId(1, 2), Fault(rate=7.0))
    arrivals = []
    for seq in range(100):
        link.fault = Fault(rate=7.0, loss=0.0, burst=1.0 + seq % 2)
        link.push(seq, seq * TICK, seq)
        arrivals += link.pop(seq * TICK)
    assert arrivals + link.pop(100.0) == whole


@given(st.lists(FAULTS, min_size=2, max_size=4), st.integers(0, 2**32), st.booleans())
@settings(max_examples=100)
def test_whatever_the_rate_was_a_link_is_as_new_once_its_queue_and_delays_are_over(
    faults: Any, seed: Any, keep_order: bool
) -> None:
    link: Link[int] = Link(seed, LinkId(1, 2))
    arrivals = []
    for seq in range(200):
        if seq % 30 == 0 and seq < 120:
            fault = faults[seq // 30 % len(faults)]
            link.fault = fault.model_copy(
                update={"keep_order": keep_order, "duplicate": 0.0, "rate": fault.rate / 100.0}
            )
        if seq == 120:
            link.fault = Fault(keep_order=keep_order)
        link.push(seq, seq * TICK, seq)
        arrivals += link.pop(seq * TICK)
    arrivals += link.pop(100.0)
    assert all(a.due >= a.sent for a in arrivals)
    assert link.counts.in_flight == 0
    assert link.counts.sent == link.counts.delivered + link.counts.lost
    if keep_order:
        assert [a.seq for a in arrivals] == sorted(a.seq for a in arrivals)
    link.push(20_000, 200.0, 1)
    assert [a.due for a in link.pop(200.0)] == [200.0]


def test_a_duplicate_is_a_second_copy_with_a_delay_of_its_own() -> None:
    link: Link[int] = Link(0, LinkId(1, 2), Fault(duplicate=1.0, latency=0.1, jitter=0.05))
    arrivals = run(link, range(100))
    by_seq = {seq: [a.due for a in arrivals if a.seq == seq] for seq in range(100)}
    assert all(len(due) == 2 for due in by_seq.values())
    assert sum(a != b for a, b in by_seq.values()) == 100
    assert link.counts.duplicated == 100


@pytest.mark.parametrize("share", [0.001, 0.3])
def test_the_share_of_duplicates_is_what_was_asked(share: Any) -> None:
    link: Link[int] = Link(0, LinkId(1, 2), Fault(duplicate=share))
    run(link, range(10_000))
    spread = math.sqrt(share * (1 - share) / 10_000)
    assert link.counts.duplicated / 10_000 == pytest.approx(share, abs=4 * spread)


# ---------------------------------------------------------------- statistics of loss, against what was asked


@pytest.mark.parametrize("loss", [0.005, 0.3, 0.9])
def test_the_mean_of_independent_loss_is_what_was_asked(loss: Any) -> None:
    count = 20_000
    lost = count - len(received(Fault(loss=loss), range(count)))
    assert lost / count == pytest.approx(loss, abs=4 * math.sqrt(loss * (1 - loss) / count))


@pytest.mark.parametrize(("loss", "burst"), [(0.1, 3.0), (0.3, 12.0), (0.5, 5.0), (0.7, 4.0), (0.9, 30.0)])
def test_mean_loss_and_mean_burst_length_are_what_was_asked(loss: Any, burst: Any) -> None:
    count, seeds = 20_000, 2
    lengths = [n for seed in range(seeds) for n in runs_of_losses(Fault(loss=loss, burst=burst), count, seed)]
    # A burst's length is geometric: its standard deviation is about its mean.
    assert np.mean(lengths) == pytest.approx(burst, rel=4 / math.sqrt(len(lengths)))
    # Losses come in bursts, so the mean loss has the spread of the number of bursts and of the gaps.
    assert sum(lengths) / (seeds * count) == pytest.approx(loss, rel=6 * (1 - loss) / math.sqrt(len(lengths)))


def test_short_bursts_are_independent_losses() -> None:
    # Independent losses of 30 % come in runs of 1 / 0.7 = 1.43 in the mean; nothing shorter is asked of the chain.
    assert received(Fault(loss=0.3, burst=1.4), range(3000)) == received(Fault(loss=0.3), range(3000))


def test_an_alternating_chain_keeps_mean_and_bursts() -> None:
    # p > 1 - r: the state changes more often than it stays, the case with the flip in between.
    loss, burst = 0.58, 2.6
    r = 1 / burst
    assert loss * r / (1 - loss) > 0.5 > r
    lengths = runs_of_losses(Fault(loss=loss, burst=burst), 30_000)
    assert np.mean(lengths) == pytest.approx(burst, rel=0.05)
    assert sum(lengths) / 30_000 == pytest.approx(loss, rel=0.05)
    gaps = 30_000 - sum(lengths)
    assert gaps / len(lengths) == pytest.approx(burst * (1 - loss) / loss, rel=0.05)


def test_the_length_of_bursts_is_geometric() -> None:
    lengths = np.array(runs_of_losses(Fault(loss=0.3, burst=6.0), 40_000))
    assert len(lengths) > 1500
    for n in (1, 3, 6, 12):  # P(length > n) = (1 - 1/6)^n
        assert np.mean(lengths > n) == pytest.approx((5 / 6) ** n, abs=0.05)


# ---------------------------------------------------------------- jitter


def delays(fault: Fault, count: int = 20_000) -> np.ndarray:
    arrivals = run(Link(5, LinkId(1, 2), fault), range(count), wait=math.inf)
    return np.array([a.due - a.sent for a in arrivals])


def test_uniform_jitter_is_within_its_half_width() -> None:
    d = delays(Fault(latency=0.1, jitter=0.04))
    assert d.min() >= 0.06 - 1e-9
    assert d.max() <= 0.14 + 1e-9
    assert d.mean() == pytest.approx(0.1, abs=0.001)
    assert d.std() == pytest.approx(0.04 / math.sqrt(3), rel=0.02)
    assert np.quantile(d, 0.25) == pytest.approx(0.08, abs=0.001)


def test_uniform_jitter_wider_than_the_latency_piles_up_at_zero() -> None:
    d = delays(Fault(latency=0.01, jitter=0.04))
    assert d.min() == 0.0
    assert np.mean(d == 0.0) == pytest.approx(0.03 / 0.08, abs=0.02)


def test_normal_jitter_has_its_standard_deviation() -> None:
    d = delays(Fault(latency=0.6, jitter=0.02, distribution="normal"))
    assert d.mean() == pytest.approx(0.6, abs=0.001)
    assert d.std() == pytest.approx(0.02, rel=0.03)
    assert np.mean(np.abs(d - 0.6) < 0.02) == pytest.approx(0.683, abs=0.015)


def test_normal_jitter_is_truncated_at_zero_and_not_piled_up_there() -> None:
    d = delays(Fault(latency=0.01, jitter=0.02, distribution="normal"))
    assert d.min() >= 0.0
    assert np.mean(d == 0.0) < 1e-3
    # Mean of a normal truncated at 0: mu + sigma phi(a) / (1 - Phi(a)), a = -mu / sigma = -0.5.
    a = -0.5
    phi, above = math.exp(-a * a / 2) / math.sqrt(2 * math.pi), 0.5 * math.erfc(a / math.sqrt(2))
    assert d.mean() == pytest.approx(0.01 + 0.02 * phi / above, rel=0.02)


def test_pareto_jitter_has_its_mean_and_a_heavy_tail() -> None:
    d = delays(Fault(latency=0.1, jitter=0.05, distribution="pareto")) - 0.1
    assert d.min() >= -1e-12
    assert d.mean() == pytest.approx(0.05, rel=0.05)
    # P(excess > x) = (1 + x / scale)^-3 with scale = 2 mean: an exponential of the same mean has 4.5e-5 there.
    assert np.mean(d > 0.5) == pytest.approx((1 + 0.5 / 0.1) ** -3, rel=0.4)


# ---------------------------------------------------------------- what draws depend on


@given(FAULTS, st.integers(0, 2**62))
@settings(max_examples=40)
def test_the_same_messages_meet_the_same_faults_in_another_link_object(fault: Any, seed: Any) -> None:
    a, b = (run(Link(seed, LinkId(1, 2), fault), range(40), wait=math.inf) for _ in range(2))
    assert a == b


@pytest.mark.parametrize(("loss", "burst"), [(0.3, 1.0), (0.3, 12.0), (0.58, 2.6), (0.9, 30.0)])
@pytest.mark.parametrize("start", [1, 137, 900])
def test_a_link_that_starts_later_gives_the_same_fates(loss: Any, burst: Any, start: Any) -> None:
    fault = Fault(loss=loss, burst=burst)
    whole = received(fault, range(1200))
    assert received(fault, range(start, 1200)) == {seq for seq in whole if seq >= start}


def test_a_gap_in_the_messages_does_not_change_the_fate_of_the_others() -> None:
    fault = Fault(loss=0.4, burst=6.0, jitter=0.01, latency=0.02, corrupt=0.1, duplicate=0.1)
    seqs = sorted(set(range(0, 1000, 7)) | set(range(300, 400)))
    whole = fate(run(Link(0, LinkId(1, 2), fault), range(1000)))
    some = fate(run(Link(0, LinkId(1, 2), fault), seqs))
    wanted = {key for key in whole if key[0] in seqs}
    # Delays are differences of stamps: they agree up to the rounding of the same sums, so exactly.
    assert set(some) == wanted
    assert len(wanted) > 50


def test_a_fault_of_another_kind_in_between_does_not_change_fates() -> None:
    bursty, other = Fault(loss=0.4, burst=6.0), Fault(loss=0.2, burst=3.0)
    link: Link[int] = Link(0, LinkId(1, 2))
    arrivals = []
    for seq in range(600):
        link.fault = other if 200 <= seq < 300 else bursty
        link.push(seq, seq * TICK, seq)
        arrivals += link.pop(seq * TICK)
    whole, between = received(bursty, range(600)), received(other, range(600))
    expected = {k for k in range(600) if k in (between if 200 <= k < 300 else whole)}
    assert {a.seq for a in arrivals} == expected


def test_the_look_back_ends_after_its_memory_and_a_long_chain_stays_cheap() -> None:
    # With bursts of 1e6 hardly a draw decides: a cold look-back meets the end of its memory.
    link: Link[int] = Link(0, LinkId(1, 2), Fault(loss=0.5, burst=1e6))
    seqs = range(10 * MEMORY, 10 * MEMORY + 200)
    came = {a.seq for a in run(link, seqs)}
    assert came in (set(), set(seqs))


def test_seed_source_target_and_seq_each_change_the_draws() -> None:
    fault = Fault(loss=0.5)
    seqs = range(200)

    def came(seed: int, link: LinkId, offset: int = 0) -> frozenset[int]:
        arrivals = run(Link(seed, link, fault), range(offset, offset + 200))
        return frozenset(a.seq - offset for a in arrivals)

    assert came(0, LinkId(1, 2)) == came(0, LinkId(1, 2))
    different = [
        came(0, LinkId(1, 2)),
        came(1, LinkId(1, 2)),
        came(0, LinkId(2, 1)),
        came(0, LinkId(1, 3)),
        came(0, LinkId(3, 2)),
        came(0, LinkId(1, 2), len(seqs)),
        came(2**63 - 1, LinkId(1, 2)),
    ]
    assert len(set(different)) == len(different)


def test_one_fault_does_not_change_the_draws_of_another() -> None:
    alone = received(Fault(loss=0.3), range(1000))
    beside = received(Fault(loss=0.3, latency=0.1, jitter=0.05, duplicate=0.5, corrupt=0.5, reorder=0.2), range(1000))
    assert alone == beside


@given(FAULTS, st.integers(0, 1000))
@settings(max_examples=40)
def test_two_controllers_meet_identical_faults(fault: Any, seed: Any) -> None:
    """What is in the messages, and when the receiver looks, does not matter."""
    a: Link[str] = Link(seed, LinkId(3, 1), fault)
    b: Link[int] = Link(seed, LinkId(3, 1), fault)
    first, second = [], []
    for seq in range(40):
        a.push(seq, seq * TICK, "a plan of nash")
        b.push(seq, seq * TICK, seq)
        first += a.pop(seq * TICK)
    first += a.pop(math.inf)
    second += b.pop(math.inf)
    assert Counter((x.seq, x.due, x.damage) for x in first) == Counter((x.seq, x.due, x.damage) for x in second)


# ---------------------------------------------------------------- damage


@given(st.binary(min_size=1, max_size=600), st.floats(0.0, 1.0, exclude_max=True))
@settings(max_examples=150)
def test_damage_flips_one_to_three_bytes(payload: Any, damage: Any) -> None:
    after = damaged(payload, damage)
    assert len(after) == len(payload)
    assert 1 <= sum(a != b for a, b in zip(payload, after, strict=True)) <= 3


def test_every_damaged_plan_is_refused_by_the_codec() -> None:
    payload = encode(PLAN)
    sizes: Counter[int] = Counter()
    for damage in np.random.default_rng(0).random(2000):
        after = damaged(payload, float(damage))
        sizes[sum(a != b for a, b in zip(payload, after, strict=True))] += 1
        with pytest.raises(WireError):
            decode(Plan, after)
    assert set(sizes) == {1, 2, 3}


def test_the_share_of_corrupt_messages_is_what_was_asked_and_their_damage_differs() -> None:
    arrivals = run(Link(0, LinkId(1, 2), Fault(corrupt=0.25)), range(8000))
    damages = [a.damage for a in arrivals if a.damage is not None]
    assert len(arrivals) == 8000
    assert len(damages) / 8000 == pytest.approx(0.25, abs=0.02)
    assert len(set(damages)) == len(damages)
    assert all(0.0 <= damage < 1.0 for damage in damages)


# ---------------------------------------------------------------- presets


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_a_fault_that_a_link_can_have(name: Any) -> None:
    fault = PRESETS[name]
    assert Fault.model_validate(fault.model_dump()) == fault
    assert fault != Fault()
    link: Link[int] = Link(0, LinkId(1, 2), fault)
    arrivals = run(link, range(500))
    assert bool(arrivals) == (name != "blackout")
    c = link.counts
    assert c.sent + c.duplicated == c.delivered + c.lost


def test_the_presets_are_those_of_the_design() -> None:
    assert set(PRESETS) == {"wifi", "congested", "satellite", "bursty", "blackout"}
    wifi = PRESETS["wifi"]
    assert (wifi.latency, wifi.jitter, wifi.loss, wifi.duplicate) == (0.02, 0.01, 0.005, 0.001)
    assert PRESETS["satellite"].latency == 0.6
    assert PRESETS["bursty"].burst > 1
    assert PRESETS["blackout"].cut
