"""Hypothesis strategies that follow from annotations: of messages, and of everything read from a scenario file.

A field that is added to a message or a model is drawn from that day on, within the constraints of its annotation.
"""

import dataclasses
import types
import typing
from functools import cache
from typing import Annotated, Any, Literal, Union

import annotated_types as limits
import numpy as np
from hypothesis import strategies as st
from pydantic import BaseModel, PlainValidator, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from formation.arrays import FloatArray
from formation.link_ids import LinkId
from network.fields import LARGEST, ArrayOf, harmless

SIZE = 3
"""Most entries of a drawn list or map, most rows of a drawn array, where the annotation allows them."""
SHORT = 20
"""Most characters of a drawn text."""
INT64 = 2**63
FINITE = st.floats(allow_nan=False, allow_infinity=False)
TEXT = st.text(max_size=SHORT)
LEAF = st.none() | st.booleans() | st.integers(-INT64, 2**64 - 1) | FINITE | TEXT
PLAIN = LEAF | st.lists(LEAF, max_size=2) | st.dictionaries(TEXT, LEAF | st.lists(LEAF, max_size=2), max_size=2)
"""What MessagePack can hold: the strategy of `Any`."""
EXTREMES = np.array([0.0, -0.0, 5e-324, -1.7976931348623157e308, 2.0**53 + 2.0, 0.1])
ENDS = st.lists(st.integers(0, 64), min_size=2, max_size=2, unique=True)
BY_TYPE: dict[object, st.SearchStrategy[Any]] = {
    Any: PLAIN,
    bool: st.booleans(),
    type(None): st.none(),
    LinkId: ENDS.map(lambda ends: LinkId(*ends)),
}
"""Types whose values do not follow from an annotation's parts."""


@st.composite
def arrays(draw: st.DrawFn, columns: int, least: int = 1, most: int = SIZE) -> FloatArray:
    """Arrays (rows, columns) of any numbers that a message may carry; by numpy, as a list of drawn floats is slow."""
    rows = draw(st.integers(least, most))
    generator = np.random.default_rng(draw(st.integers(0, 2**32)))
    usual = generator.standard_normal((rows, columns)) * 10.0 ** generator.integers(-300, 300, (rows, columns))
    found = np.where(generator.random((rows, columns)) < 0.2, generator.choice(EXTREMES, (rows, columns)), usual)
    return np.clip(found, -LARGEST, LARGEST)


def of(kind: Any) -> st.SearchStrategy[Any]:
    """Values that an annotation allows; of a dataclass or a model, whole ones with every field drawn.

    Raises:
        TypeError: the annotation has a part for which there is no rule here yet.
    """
    return _of(kind, ())


def _of(kind: Any, rules: tuple[Any, ...]) -> st.SearchStrategy[Any]:
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin is Annotated:
        return _of(arguments[0], (*rules, *_flat(arguments[1:])))
    if array := next((rule.func for rule in rules if _is_array(rule)), None):
        return _array(array)
    if kind in BY_TYPE:
        return BY_TYPE[kind]
    if kind in (int, float, str):
        return _scalar(kind, rules)
    if origin is Literal:
        return st.sampled_from(arguments)
    if origin in (Union, types.UnionType):
        return st.one_of(*(_of(argument, ()) for argument in arguments))
    if origin in (list, tuple, dict):
        return _container(origin, arguments, rules)
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return _whole(kind)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return _model(kind)
    raise TypeError(f"expected an annotation that tests/strategies.py knows; got {kind!r}")


def _flat(rules: tuple[Any, ...]) -> list[Any]:
    """The rules with those inside a pydantic Field; what does not restrict values is left out."""
    found: list[Any] = []
    for rule in rules:
        found += rule.metadata if isinstance(rule, FieldInfo) else [rule]
    return found


def _is_array(rule: object) -> bool:
    return isinstance(rule, PlainValidator) and isinstance(rule.func, ArrayOf)


def _array(shape: ArrayOf) -> st.SearchStrategy[FloatArray]:
    if shape.most is not None and shape.columns is not None:
        bound = np.array(shape.most)
        return arrays(shape.columns, 0 if shape.empty else 1).map(lambda values: np.clip(values, -bound, bound))
    if shape.columns is None:
        return arrays(1, 0).map(lambda values: values[:, 0].copy())
    if shape.rows == 1:
        return arrays(shape.columns, 1, 1).map(lambda values: values[0])
    return arrays(shape.columns) if shape.rows is None else arrays(shape.columns, shape.rows, shape.rows)


def _bound(rules: tuple[Any, ...], kind: type, name: str) -> Any:
    return next((getattr(rule, name) for rule in rules if isinstance(rule, kind) and hasattr(rule, name)), None)


def _scalar(kind: type, rules: tuple[Any, ...]) -> st.SearchStrategy[Any]:
    at_least, more = _bound(rules, limits.Ge, "ge"), _bound(rules, limits.Gt, "gt")
    at_most, less = _bound(rules, limits.Le, "le"), _bound(rules, limits.Lt, "lt")
    if kind is str:
        pattern = next((rule.pattern for rule in rules if getattr(rule, "pattern", None)), None)
        if pattern:
            return st.from_regex(pattern, fullmatch=True)
        return st.text(max_size=min(SHORT, _bound(rules, limits.MaxLen, "max_length") or SHORT)).map(harmless)
    if kind is int:
        low = more + 1 if more is not None else -INT64 if at_least is None else at_least
        high = less - 1 if less is not None else INT64 - 1 if at_most is None else at_most
        return st.integers(low, high)
    low = at_least if more is None else more
    high = at_most if less is None else less
    return st.floats(
        low, high, exclude_min=more is not None, exclude_max=less is not None, allow_nan=False, allow_infinity=False
    )


def _container(origin: type, arguments: tuple[Any, ...], rules: tuple[Any, ...]) -> st.SearchStrategy[Any]:
    least = _bound(rules, limits.MinLen, "min_length") or 0
    most = _bound(rules, limits.MaxLen, "max_length") or max(SIZE, least)
    if origin is dict:
        return st.dictionaries(_of(arguments[0], ()), _of(arguments[1], ()), min_size=least, max_size=most)
    if origin is list or (len(arguments) == 2 and arguments[1] is Ellipsis):
        return st.lists(_of(arguments[0], ()), min_size=least, max_size=most).map(origin)
    return st.tuples(*(_of(argument, ()) for argument in arguments))


@cache
def _whole(kind: type[Any]) -> st.SearchStrategy[Any]:
    """Instances of a dataclass with every field drawn, defaults included."""
    hints = typing.get_type_hints(kind, include_extras=True)
    return st.builds(kind, **{field.name: _of(hints[field.name], ()) for field in dataclasses.fields(kind)})


@cache
def _model(kind: type[BaseModel]) -> st.SearchStrategy[Any]:
    """Instances of a model; any key that has a default may be absent, and what its validators refuse is left out."""
    fields = kind.model_fields.items()
    drawn = {name: _of(field.annotation, tuple(field.metadata)) for name, field in fields}
    optional = {name for name, field in fields if field.get_default(call_default_factory=True) is not PydanticUndefined}
    required = {name: values for name, values in drawn.items() if name not in optional}
    tables = st.fixed_dictionaries(required, optional={name: drawn[name] for name in optional})
    return tables.map(lambda table: _valid(kind, table)).filter(lambda value: value is not None)


def _valid(kind: type[BaseModel], table: dict[str, Any]) -> BaseModel | None:
    try:
        return kind.model_validate(table)
    except ValidationError:
        return None
