"""Every key of a scenario file with its type, unit, range, default and description: a view of the JSON schema."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from formation.scenario.json_schema import json_schema
from formation.schema import UNIT

UNITS = ("1", "m", "s", "rad", "m/s", "rad/s", "m/s2", "rad/s2", "1/s", "messages", "messages/s", "intervals", "ticks")
"""What a docstring may name in brackets as the unit of a key; 1 is that of a plain number."""
_BRACKETS = re.compile(r"\[([^\[\]]+)\]")
TAG = "choice of a kind"
"""Type of the key by which a table says which of several it is."""
_TYPES = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "table",
}
REQUIRED, ABSENT = "required", "absent"
"""Defaults of a key that has none, and of one that may be left out."""


class Key(NamedTuple):
    """A key of a scenario file, or of another that follows from a model."""

    path: str
    """Such as link.latency; faults[].at is a key of each of several tables."""
    of: tuple[str, ...]
    """Kinds or names of the table that has this key; empty if all of them have it."""
    type: str
    unit: str
    """Empty for what is no number."""
    range: str
    default: str
    """As TOML has it, or `required`, or `absent`."""
    text: str
    """Its docstring."""


def keys(schema: Mapping[str, Any] | None = None) -> list[Key]:
    """All keys, in the order of the schema; those of a table behind it.

    Args:
        schema: of another kind of file; a scenario's, if absent.
    """
    schema = json_schema() if schema is None else schema
    found: dict[object, Key] = {}
    for key in _of_table(schema, schema, ""):
        same = key.path if key.type == TAG else (key.path, *key[2:])
        found[same] = _together(found[same], key) if same in found else key
    kinds = _kinds(schema)
    everywhere = [set(key.of) >= kinds.get(key.path.partition(".")[0], {""}) for key in found.values()]
    return [key._replace(of=()) if all_ else key for key, all_ in zip(found.values(), everywhere, strict=True)]


def _together(one: Key, other: Key) -> Key:
    """The same key of several tables; of the key that says which table it is, all values."""
    both = one._replace(of=(*one.of, *other.of))
    return both._replace(range=f"{one.range}, {other.range}") if one.type == TAG else both


def matching(word: str) -> list[Key]:
    """Keys whose path has the word in it."""
    return [key for key in keys() if word in key.path]


def _kinds(schema: Mapping[str, Any]) -> dict[str, set[str]]:
    """Of each table that is one of several, their kinds."""
    found = {}
    for name, part in schema["properties"].items():
        tags = {tag for table, tag in _tables(part, schema) if tag}
        if tags:
            found[name] = tags
    return found


def _of_table(table: Mapping[str, Any], schema: Mapping[str, Any], above: str, tag: str = "") -> Iterator[Key]:
    required = table.get("required", ())
    for name, part in table["properties"].items():
        path = f"{above}{name}"
        inner = _tables(part, schema)
        text = " ".join((part.get("description") or _text(part, inner)).split())
        yield Key(
            path,
            (tag,) if tag else (),
            _type(part, tables=bool(inner)),
            "" if inner else _unit(part, text),
            "" if inner else _range(part),
            REQUIRED if name in required else "" if inner else _default(part),
            text,
        )
        for definition, kind in inner:
            yield from _of_table(definition, schema, f"{path}[]." if _many(part) else f"{path}.", kind or tag)


def _text(part: Mapping[str, Any], tables: list[tuple[Mapping[str, Any], str]]) -> str:
    """Of a key without a docstring: that of its table."""
    if "const" in part:
        return "Which of these it is."
    return str(tables[0][0]["description"]).partition("\n\n")[0] if len(tables) == 1 else ""


def _tables(part: Mapping[str, Any], schema: Mapping[str, Any]) -> list[tuple[Mapping[str, Any], str]]:
    """The tables that may stand here, with the tag by which one of several says which it is."""
    choices = [part, *part.get("anyOf", ()), *([part["items"]] if "items" in part else [])]
    names = [choice["$ref"].rpartition("/")[2] for choice in choices if "$ref" in choice]
    found = [schema["$defs"][name] for name in names]
    return [(table, _tag(table) if len(found) > 1 else "") for table in found]


def _tag(table: Mapping[str, Any]) -> str:
    return next(str(part["const"]) for part in table["properties"].values() if "const" in part)


def _many(part: Mapping[str, Any]) -> bool:
    return "$ref" in part.get("items", {})


def _choices(part: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """What may stand here, nothing aside."""
    if "anyOf" not in part:
        return [part]
    return [one for choice in part["anyOf"] for one in _choices(choice) if one.get("type") != "null"]


def _type(part: Mapping[str, Any], *, tables: bool) -> str:
    if tables:
        return "tables" if _many(part) else "table"
    if "const" in part:
        return TAG
    kinds = []
    for choice in _choices(part):
        if "enum" in choice:
            kinds.append("choice")
        elif choice["type"] == "array":
            kinds.append("list")
        else:
            kinds.append(_TYPES[choice["type"]])
    return " or ".join(dict.fromkeys(kinds))


def _unit(part: Mapping[str, Any], text: str) -> str:
    """In the docstring's brackets, or what the type says."""
    for inside in _BRACKETS.findall(text):
        if all(unit.strip() in UNITS for unit in inside.split(",")):
            return str(inside)
    own = [choice[UNIT] for choice in (part, *part.get("anyOf", ())) if UNIT in choice]
    return str(own[0]) if own else ""


def _range(part: Mapping[str, Any]) -> str:
    return " or ".join(dict.fromkeys(filter(None, (_limits(choice) for choice in _choices(part)))))


def _limits(choice: Mapping[str, Any]) -> str:
    """The values of one type that are allowed; empty for all of them."""
    if "enum" in choice or "const" in choice:
        return ", ".join(map(str, choice.get("enum", [choice.get("const")])))
    if choice["type"] == "array":
        return _length(choice)
    low, high = choice.get("minimum"), choice.get("maximum")
    more, less = choice.get("exclusiveMinimum"), choice.get("exclusiveMaximum")
    words = [
        f"at least {low:g}" if low is not None else "",
        f"more than {more:g}" if more is not None else "",
        f"at most {high:g}" if high is not None else "",
        f"less than {less:g}" if less is not None else "",
    ]
    if low is not None and high is not None:
        return f"{low:g} to {high:g}"
    return ", ".join(filter(None, words))


def _length(choice: Mapping[str, Any]) -> str:
    least, most = choice.get("minItems"), choice.get("maxItems")
    if least == most and least is not None:
        size = f"{least} values"
    elif least is None and most is None:
        size = ""
    else:
        size = f"at least {least} values" if most is None else f"{least or 0} to {most} values"
    items = choice.get("prefixItems", [choice.get("items", {})])
    each = dict.fromkeys(filter(None, (_range(item) for item in items if item.get("type") or "anyOf" in item)))
    return ", ".join(filter(None, [size, *(f"each {words}" for words in each)]))


def _default(part: Mapping[str, Any]) -> str:
    value = part.get("default")
    return ABSENT if value is None else json.dumps(value)
