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
LABEL = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$"
"""Pattern of what tables and the page call something."""
COLUMN = r"^[a-z][a-z0-9_]{0,39}$"
"""Pattern of a name that is a column of a table, too."""
_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


_EXPECTED = {
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "string": "text",
    "tuple": "a list",
    "list": "a list",
    "model": "a table",
    "dict": "a table",
}
"""What a user calls what a type of pydantic's mistakes, such as int_parsing, begins with."""
_PATTERNS = {
    LABEL: "a name of at most 64 letters, digits and _ . - that begins with a letter or a digit",
    COLUMN: "a name of at most 40 small letters, digits and _ that begins with a letter",
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
    return _joined(line + more[kind] for kind, line in first.items())


def _joined(lines: Iterable[str]) -> list[str]:
    """The lines, where those about a key of several types, and so about one value, are one."""
    found: dict[str, str] = {}
    for line in lines:
        key, _, rest = line.partition(": expected ")
        before, (more, got, _) = found.get(key, ""), rest.rpartition("; got ")
        if "; got " not in before or not got:
            found[line if key in found else key] = line
            continue
        whole, _, value = before.rpartition("; got ")
        choices = getattr(before, "choices", ()) or getattr(line, "choices", ())
        found[key] = Line(f"{whole} or {more}; got {value}", key, choices)
    return list(found.values())


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
    if kind == "string_pattern_mismatch":
        words = _PATTERNS.get(context["pattern"], f"text of the form {context['pattern']}")
        return f"{key}: expected {words}; got {shown(got)}"
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
        return _told(key, context["error"])
    text = _EXPECTED.get(kind.partition("_")[0]) or item["msg"].removeprefix("Input should be ")
    field = owner.model_fields.get(names[-1]) if owner and names else None
    if text == "a list" and field and _models(field.annotation):
        text = "a list of tables"
    return f"{key}: expected {text}; got {shown(got)}"


def _told(key: str, error: Exception) -> str:
    """What a validator of our own says of a value; of a key in the table that it has looked at, with that key."""
    line = error.args[0] if error.args else ""
    if not isinstance(line, Line) or not line.path.isidentifier():
        return f"{key}: {error}"
    return Line(f"{key}.{line}", f"{key}.{line.path}", line.choices)


def _walk(
    location: tuple[int | str, ...], model: type[BaseModel]
) -> tuple[list[str], type[BaseModel] | None, list[type[BaseModel]]]:
    """Key names without the tags of unions, the model that owns the last of them, and the others of its union."""
    others: list[type[BaseModel]] = []
    names: list[str] = []
    owner: type[BaseModel] | None = model
    here: list[type[BaseModel]] = [model]
    several = False
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
        if several:
            several = False  # pydantic's name of one of several types, none of which is a table
            continue
        owner = here[0] if here else None
        names.append(part)
        field = owner.model_fields.get(part) if owner else None
        here = _models(field.annotation) if field else []
        several = field is not None and not here and _is_union(field.annotation)
    return names, owner, others


def _tag(model: type[BaseModel]) -> str | None:
    for name in TAGS:
        field = model.model_fields.get(name)
        if field and get_origin(field.annotation) is Literal:
            return str(get_args(field.annotation)[0])
    return None


def _is_union(annotation: Any) -> bool:
    """Whether values may be of several types, beside None."""
    kinds = [kind for kind in get_args(annotation) if kind is not types.NoneType]
    return get_origin(annotation) in (Union, types.UnionType) and len(kinds) > 1


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Every model that occurs in a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) in (Union, types.UnionType, Annotated, list, tuple):
        return [m for part in get_args(annotation) for m in _models(part)]
    return []
