"""Laws of the strategies: whatever an annotation allows is drawn, field by field, and nothing else."""

import dataclasses
import typing
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, Field, TypeAdapter

from formation.disturbances import Disturbance
from formation.faults import Fault
from formation.scenario.robots import Limits, Noise, StartNoise
from formation.scenario.user_code import UserCode
from network.fields import Count, Inputs, Numbers, Pose, Positive
from network.messages import Message
from network.stretch import Order
from network.values import Driving, Event, Excursion, LinkCounts, Motion, Pushed
from tests.strategies import of

WHOLE = [*typing.get_args(Message), LinkCounts, Event, Driving, Order, Motion, Pushed, Excursion, Fault, UserCode]
MODELS = [Fault, Disturbance, Limits, Noise, StartNoise]


def fields_of(kind: Any) -> Iterator[str]:
    if dataclasses.is_dataclass(kind):
        yield from (field.name for field in dataclasses.fields(kind))
    else:
        yield from kind.model_fields


def seen(kind: Any, examples: int) -> dict[str, set[str]]:
    """By field of a class, the different values in so many examples."""
    values: dict[str, set[str]] = {name: set() for name in fields_of(kind)}

    @settings(max_examples=examples)
    @given(of(kind))
    def look(value: Any) -> None:
        for name, different in values.items():
            different.add(repr(getattr(value, name)))

    look()
    return values


@pytest.mark.parametrize("kind", WHOLE, ids=lambda kind: kind.__name__)
def test_every_field_of_every_message_takes_several_values(kind: Any) -> None:
    values = seen(kind, 60)
    assert values
    assert {name: len(different) for name, different in values.items() if len(different) < 2} == {}


def test_every_class_inside_a_message_is_drawn_whole() -> None:
    found: set[str] = set()

    def collect(value: Any) -> None:
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            found.add(type(value).__name__)
            for field in dataclasses.fields(value):
                collect(getattr(value, field.name))
        elif isinstance(value, list | dict):
            for item in value.values() if isinstance(value, dict) else value:
                collect(item)
        elif isinstance(value, BaseModel):
            found.add(type(value).__name__)

    @settings(max_examples=20)
    @given(st.tuples(*(of(kind) for kind in typing.get_args(Message))))
    def look(messages: Any) -> None:
        for message in messages:
            collect(message)

    look()
    assert found == {kind.__name__ for kind in WHOLE}


@pytest.mark.parametrize("kind", MODELS, ids=lambda kind: kind.__name__)
def test_every_key_of_a_model_takes_several_values(kind: Any) -> None:
    values = seen(kind, 150)
    assert {name: len(different) for name, different in values.items() if len(different) < 2} == {}


def test_a_field_that_is_added_is_drawn_without_a_line_in_the_tests() -> None:
    grown = dataclasses.make_dataclass("Grown", [("old", Count), ("new", Annotated[int, Field(ge=3, le=5)], 4)])
    assert seen(grown, 60)["new"] == {"3", "4", "5"}


@pytest.mark.parametrize(
    "annotation",
    [
        Count,
        Positive,
        Annotated[float, Field(ge=-1.0, lt=1.0)],
        Annotated[str, Field(max_length=2)],
        Annotated[list[Count], Field(min_length=2, max_length=2)],
        tuple[Count, ...],
        tuple[Positive, Positive],
        dict[str, Count],
        Literal["a", 1],
        Count | None,
    ],
    ids=str,
)
def test_what_is_drawn_is_what_pydantic_accepts(annotation: Any) -> None:
    adapter = TypeAdapter(annotation)

    @settings(max_examples=40)
    @given(of(annotation))
    def law(value: Any) -> None:
        assert adapter.validate_python(value) == value

    law()


@pytest.mark.parametrize(
    ("annotation", "shapes"),
    [(Pose, {(3,)}), (Inputs, {(1, 2), (2, 2), (3, 2)}), (Numbers, {(0,), (1,), (2,), (3,)})],
    ids=["pose", "inputs", "numbers"],
)
def test_an_array_has_the_columns_and_rows_of_its_annotation(annotation: Any, shapes: Any) -> None:
    found: set[tuple[int, ...]] = set()

    @settings(max_examples=60)
    @given(of(annotation))
    def law(value: Any) -> None:
        assert np.isfinite(value).all()
        found.add(value.shape)

    law()
    assert found == shapes


def test_an_annotation_without_a_rule_is_an_error_and_not_a_guess() -> None:
    with pytest.raises(TypeError, match="complex"):
        of(complex)
