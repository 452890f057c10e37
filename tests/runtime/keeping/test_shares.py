"""Laws of shares: whoever comes and goes, every robot has one keeper, and no keeper has two more than another."""

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from runtime.keeping.shares import Shares

NUMBERS = st.integers(0, 2**32 - 1)


@given(
    st.sets(NUMBERS, min_size=1, max_size=9),
    st.sets(NUMBERS, max_size=5),
    st.integers(1, 64),
    st.randoms(use_true_random=False),
)
def test_every_robot_has_exactly_one_keeper(here: set[int], gone: set[int], robots: int, order: Random) -> None:
    everybody = [*here, *(gone - here)]
    parts = []
    for own in here:
        shares = Shares(own)
        order.shuffle(everybody)  # each hears of the others in its own order
        for keeper in everybody:
            shares.note(keeper, here=True)
        for keeper in gone - here:
            shares.note(keeper, here=False)
        parts.append(shares.of(range(1, robots + 1)))
    assert sorted(robot for part in parts for robot in part) == list(range(1, robots + 1))
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
