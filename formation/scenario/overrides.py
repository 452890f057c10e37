"""Overrides of a scenario as nested data: {"link": {"latency": 0.3}} is what `--set link.latency=0.3` means."""

import copy
import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from formation.errors import ScenarioError
from formation.validation import shown

Overrides = Mapping[str, Any]
"""Tables by key, as TOML has them."""
DEEPEST = 8
"""Tables within tables; no scenario has so many."""
KIND = "kind"
"""The key that tells which other keys a table has: a path of another kind keeps nothing of the old one."""


def at_path(path: str, value: object) -> dict[str, Any]:
    """One value at the path of a key such as link.latency."""
    *above, last = (part.strip() for part in path.split("."))
    found = {last: value}
    for key in reversed(above):
        found = {key: found}
    return found


def paths(overrides: Overrides, above: str = "") -> Iterator[str]:
    """Paths of all keys that are set; those of a table are its keys'."""
    for key, value in overrides.items():
        if isinstance(value, Mapping) and value:
            yield from paths(value, f"{above}{key}.")
        else:
            yield f"{above}{key}"


def is_deep(table: Overrides) -> bool:
    """Whether tables lie deeper within tables than in any scenario: what recurs into them must not recur for ever."""
    level: list[object] = [table]
    for _ in range(DEEPEST + 2):
        tables = [item for item in level if isinstance(item, Mapping)]
        level = [value for item in tables for value in item.values()]
        level += [value for item in level if isinstance(item, list | tuple) for value in item]
    return any(isinstance(item, Mapping) for item in level)


def merged(table: Overrides, *more: Overrides) -> dict[str, Any]:
    """A table with overrides, the later ones first; nothing is shared with the arguments.

    Tables are merged key by key. An empty table empties the one below it: `robots = {}` drops the start poses.
    """
    result: dict[str, Any] = copy.deepcopy(dict(table))
    for overrides in more:
        for key, value in overrides.items():
            below = result.get(key)
            if isinstance(value, Mapping) and value and isinstance(below, Mapping) and _same_kind(below, value):
                result[key] = merged(below, value)
            else:
                result[key] = copy.deepcopy(value)
    return result


def _same_kind(below: Overrides, value: Overrides) -> bool:
    return KIND not in value or below.get(KIND) == value[KIND]


def from_settings(settings: Iterable[str]) -> dict[str, Any]:
    """The overrides that settings such as link.latency=0.3 stand for; a later one wins.

    The value is TOML; what is not TOML is text.

    Raises:
        ScenarioError: a setting is not of the form key=value.
    """
    overrides: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals or not all(part.strip() for part in key.split(".")) or key.count(".") > DEEPEST:
            raise ScenarioError(f"--set: expected key=value; got {shown(setting)}")
        overrides = merged(overrides, at_path(key, from_text(text)))
    return overrides


def from_text(text: str) -> Any:
    """The TOML value of a text; the text itself if it is none."""
    try:
        table = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, RecursionError):
        return text.strip()
    return table["value"] if len(table) == 1 else text.strip()


def to_json(overrides: Overrides) -> str:
    """The overrides as one argument of a process."""
    return json.dumps(overrides)


def from_json(text: str) -> dict[str, Any]:
    """The overrides that `to_json` wrote.

    Raises:
        ScenarioError: the text is no JSON object.
    """
    try:
        overrides = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ScenarioError(f"--overrides: expected a JSON object; {error}") from None
    if not isinstance(overrides, dict):
        raise ScenarioError(f"--overrides: expected a JSON object; got {text:.40}")
    return overrides
