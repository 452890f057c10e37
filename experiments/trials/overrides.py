"""Overrides of a scenario as nested data: {"link": {"latency": 0.3}} is what `--set link.latency=0.3` means."""

import copy
from collections.abc import Iterator, Mapping
from typing import Any

Overrides = Mapping[str, Any]
"""Tables by key, as TOML has them."""
KIND = "kind"
"""The key that tells which other keys a table has: a path of another kind keeps nothing of the old one."""


def at_path(path: str, value: object) -> dict[str, Any]:
    """One value at the path of a key such as link.latency."""
    first, dot, rest = path.strip().partition(".")
    return {first: at_path(rest, value) if dot else value}


def paths(overrides: Overrides, above: str = "") -> Iterator[str]:
    """Paths of all keys that are set; those of a table are its keys'."""
    for key, value in overrides.items():
        if isinstance(value, Mapping) and value:
            yield from paths(value, f"{above}{key}.")
        else:
            yield f"{above}{key}"


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
