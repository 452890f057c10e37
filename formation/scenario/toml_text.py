"""A scenario as the text of a TOML file, which `load` reads again."""

import json
from collections.abc import Mapping
from typing import Any

from formation.scenario.scenario import Scenario

LONG = 100
"""Characters of a line, after which the values of a list go on in the next."""


def as_toml(scenario: Scenario) -> str:
    """All that was given of a scenario, and nothing that it has by default."""
    return "\n".join(_table(scenario.model_dump(mode="json", exclude_unset=True), "")) + "\n"


def _table(values: Mapping[str, Any], name: str) -> list[str]:
    """Lines of a table: its plain values first, then the tables in it."""
    given = {key: value for key, value in values.items() if value is not None}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in given.items() if not _is_table(value)]
    if name and (lines or not given):
        lines.insert(0, f"[{name}]")
    for key, value in given.items():
        if isinstance(value, Mapping):
            lines += _table(value, f"{name}.{_key(key)}" if name else _key(key))
    return lines


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping)


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else json.dumps(key)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        inside = ", ".join(f"{_key(key)} = {_value(one)}" for key, one in value.items() if one is not None)
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        return _list([_value(one) for one in value])
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return json.dumps(value)


def _list(values: list[str]) -> str:
    """A list in one line, or in lines of their own if it is long."""
    if sum(map(len, values)) + 2 * len(values) < LONG:
        return f"[{', '.join(values)}]"
    lines, line = list[str](), ""
    for value in values:
        if line and len(line) + len(value) > LONG:
            lines.append(line)
            line = ""
        line += f"{value}, "
    return "[\n" + "".join(f"  {one.rstrip()}\n" for one in [*lines, line]) + "]"
