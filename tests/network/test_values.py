"""A quick constructor makes what the frozen dataclass's own makes, and it stays frozen."""

import dataclasses
import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest

from network.codec import encode
from network.messages import Command, Plan, Tick
from network.values import maker, tuple_maker
from tests import builders

MESSAGES = [
    builders.plan(1, 3, lag=0.25, number=7),
    builders.command(2, 5, failure="text"),
    builders.tick(4, np.zeros((3, 3)), gone=[2]),
]


class Pair(NamedTuple):
    one: int
    other: str = "other"


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_it_makes_what_the_class_makes(message: Plan | Command | Tick) -> None:
    kind: Any = type(message)
    given = {f.name: getattr(message, f.name) for f in dataclasses.fields(kind)}
    needed = {f.name: given[f.name] for f in dataclasses.fields(kind) if f.default is f.default_factory}
    for arguments in (given, needed):
        made, same = maker(kind)(**arguments), kind(**arguments)
        assert type(made) is kind
        assert encode(made) == encode(same)
        assert pickle.dumps(made) == pickle.dumps(same)
        assert encode(maker(kind)(*arguments.values())) == encode(same)
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.seq = 1
    with pytest.raises(TypeError):
        maker(kind)()


def test_what_has_a_default_factory_is_made_anew() -> None:
    make = maker(Tick)
    given = {f.name: getattr(MESSAGES[2], f.name) for f in dataclasses.fields(Tick) if f.name != "gone"}
    assert make(**given).gone is not make(**given).gone


def test_of_a_named_tuple_likewise() -> None:
    make = tuple_maker(Pair)
    for made, same in (
        (make(1), Pair(1)),
        (make(1, "two"), Pair(1, "two")),
        (make(other="two", one=1), Pair(1, "two")),
    ):
        assert type(made) is Pair
        assert made == same
    with pytest.raises(TypeError):
        make()  # type: ignore[call-arg]
