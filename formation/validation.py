"""Validation errors as one line each: the key's path, what was expected, what was got."""

import types
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from formation.errors import Line, unknown

TAGS = ("kind", "name")
"""Keys by which a table says which of several models it is."""
_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


LINE = "line"
"""Type of a mistake that has its line already."""
LONGEST = 60
"""Characters of a wrong value that a line shows."""


def problems(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """One line per mistake in what was to become a `model`; mistakes of one kind in the rows of a list share a line."""
    first: dict[object, str] = {}
    count: Counter[object] = Counter()
    for item in error.errors(include_url=False):
        kind = _kind(dict(item))
        count[kind] += 1
        if kind not in first:
            first[kind] = _line(dict(item), model)
    more = {kind: f" (and {n - 1} more like it)" if n > 1 else "" for kind, n in count.items()}
    return [line + more[kind] for kind, line in first.items()]


def as_lines(error: ValidationError, model: type[BaseModel], others: Iterable[type[BaseModel]] = ()) -> ValidationError:
    """The same mistakes with their lines, for whoever validates the table that has this one inside.

    Args:
        error: raised by `model`.
        model: that the table names; the one outside cannot know it.
        others: models that it might have named instead.
    """
    found: list[InitErrorDetails] = []
    for item in error.errors(include_url=False):
        whole = _line(dict(item), model)
        line, choices = whole.partition(": ")[2], getattr(whole, "choices", ())
        if item["type"] == "extra_forbidden":
            line += _whose(str(item["loc"][-1]), [other for other in others if other is not model])
        found.append(
            {
                "type": PydanticCustomError(LINE, "{error}", {"error": line, "choices": choices}),
                "loc": item["loc"],
                "input": None,
            }
        )
    return ValidationError.from_exception_data(model.__name__, found)


def mistake(key: str, line: str, choices: Iterable[str] = ()) -> ValidationError:
    """One mistake in the value of a key, for whoever validates the table."""
    kind = PydanticCustomError(LINE, "{error}", {"error": line, "choices": [*choices]})
    return ValidationError.from_exception_data(key, [{"type": kind, "loc": (key,), "input": None}])


def _whose(key: str, others: list[type[BaseModel]]) -> str:
    whose = [str(_tag(other)) for other in others if key in other.model_fields]
    return f"; it is a key of {', '.join(whose)}" if whose else ""


def _kind(item: dict[str, Any]) -> object:
    """What mistakes have in common that differ by their row only."""
    names = tuple(part for part in item["loc"] if not isinstance(part, int))
    return names, item["type"], item["msg"] if item["type"] in ("value_error", LINE) else ""


def shown(value: object) -> str:
    """A value as a line shows it."""
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ..."


def _line(item: dict[str, Any], model: type[BaseModel]) -> str:
    names, owner, others = _walk(item["loc"], model)
    key = ".".join(names) or "file"
    kind, context, got = item["type"], item.get("ctx", {}), item["input"]
    if kind == "extra_forbidden":
        line = unknown(f"{key}: unknown key", names[-1], owner.model_fields if owner else [])
        return line + _whose(names[-1], others)
    if kind in ("too_long", "too_short"):
        bounds = {"List": f"at {'most' if kind == 'too_long' else 'least'} ", "Tuple": ""}
        size = context.get("max_length", context.get("min_length"))
        return f"{key}: expected {bounds.get(context['field_type'], '')}{size} values; got {context['actual_length']}"
    if kind == "missing" and isinstance(item["loc"][-1], int):
        return f"{key.rpartition('[')[0]}: expected more values; got {len(got)}"
    if kind == "missing":
        return f"{key}: expected a value; got nothing"
    if kind == "union_tag_not_found":
        return f"{key}: expected a key {context['discriminator']}; got none"
    if kind == "union_tag_invalid":
        choices = [choice.strip(" '") for choice in context["expected_tags"].split(",")]
        return unknown(f"{key}.{context['discriminator'].strip(chr(39))}", context["tag"], choices)
    if kind == "literal_error":
        choices = [c.strip("' ") for c in context["expected"].replace(" or ", ",").split(",")]
        return unknown(key, str(got)[:LONGEST], choices)
    if kind in _BOUNDS:
        bound, words = _BOUNDS[kind]
        return f"{key}: expected {words} {context[bound]:g}; got {shown(got)}"
    if kind == LINE:
        return Line(f"{key}: {context['error']}", key, context.get("choices", ()))
    if kind == "value_error":
        return f"{key}: {context['error']}"
    text = item["msg"].removeprefix("Input should be ").removeprefix("a valid ")
    return f"{key}: expected {text}; got {shown(got)}"


def _walk(
    location: tuple[int | str, ...], model: type[BaseModel]
) -> tuple[list[str], type[BaseModel] | None, list[type[BaseModel]]]:
    """Key names without the tags of unions, the model that owns the last of them, and the others of its union."""
    others: list[type[BaseModel]] = []
    names: list[str] = []
    owner: type[BaseModel] | None = model
    here: list[type[BaseModel]] = [model]
    for part in location:
        if isinstance(part, int):
            names[-1:] = [f"{names[-1]}[{part}]"] if names else [f"[{part}]"]
            continue
        tagged = [m for m in here if len(here) > 1 and _tag(m) == part]
        if tagged:
            others = [m for m in here if m not in tagged]
            here = tagged
            owner = here[0]
            continue
        if not here or owner is not here[0]:
            others = []
        owner = here[0] if here else None
        names.append(part)
        field = owner.model_fields.get(part) if owner else None
        here = _models(field.annotation) if field else []
    return names, owner, others


def _tag(model: type[BaseModel]) -> str | None:
    for name in TAGS:
        field = model.model_fields.get(name)
        if field and get_origin(field.annotation) is Literal:
            return str(get_args(field.annotation)[0])
    return None


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Every model that occurs in a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) in (Union, types.UnionType, Annotated, list, tuple):
        return [m for part in get_args(annotation) for m in _models(part)]
    return []
