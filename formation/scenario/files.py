"""Scenarios from files: by name or path, with settings applied, every mistake in a line of its own."""

import copy
import json
import tomllib
from collections.abc import Iterable
from pathlib import Path as File
from typing import Any

from pydantic import ValidationError

from formation.errors import ScenarioError, unknown
from formation.paths.files import text_of, with_files
from formation.scenario.scenario import Scenario
from formation.schema import MAX_SCENARIO
from formation.validation import problems

SHIPPED = File(__file__).parents[2] / "scenarios"


def shipped() -> list[str]:
    """Names of the scenarios that come with the project."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


def load(name: str, settings: Iterable[str] = ()) -> Scenario:
    """A scenario by its name or its TOML file, with `key=value` settings applied.

    Raises:
        ScenarioError: it does not exist or is wrong; one line per mistake.
    """
    file = File(name)
    beside = file.is_file() or file.suffix.lower() == ".toml"  # a pipe has nothing beside it
    return parse(read(name), settings, where=name, folder=file.parent if is_file(name) and beside else File())


def read(name: str) -> dict[str, Any]:
    """The raw table of a scenario by its name or its file: TOML, or JSON as a launcher hands it on.

    Raises:
        ScenarioError: there is no such scenario, or it cannot be read.
    """
    if not is_file(name):
        file = SHIPPED / f"{name}.toml"
        if not file.is_file():
            raise ScenarioError(unknown("scenario", name, [*shipped(), "FILE.toml"]))
        return tomllib.loads(file.read_text(encoding="utf-8"))
    text = text_of(File(name), name, MAX_SCENARIO)
    try:
        if name.endswith(".json"):
            return dict(json.loads(text))
        return tomllib.loads(text)
    except (TypeError, ValueError, RecursionError) as error:  # what TOML and JSON raise are ValueErrors
        raise ScenarioError(f"{name}: expected {'JSON' if name.endswith('.json') else 'TOML'}; {error}") from None


def is_file(name: str) -> bool:
    """Whether a scenario is meant by its file, a pipe as well, and not by its name."""
    return name.lower().endswith((".toml", ".json")) or "/" in name


def parse(
    raw: dict[str, Any], settings: Iterable[str] = (), *, where: str = "scenario", folder: File | None = None
) -> Scenario:
    """A scenario from its raw table.

    Args:
        raw: the table.
        settings: key=value, applied to it.
        where: what errors begin with.
        folder: in which files that it names are sought; without it no file is read.

    Raises:
        ScenarioError: one line per mistake.
    """
    raw = copy.deepcopy(raw)
    for setting in settings:
        _apply(raw, setting)
    if folder is not None:
        raw = with_files(raw, folder, where)
    try:
        scenario = Scenario.model_validate(raw)
    except ValidationError as error:
        lines = [line.removeprefix("file: ") for line in problems(error, Scenario)]
        raise ScenarioError("\n".join(f"{where}: {line}" for line in lines)) from None
    size = len(scenario.model_dump_json(exclude_unset=True))
    if size > MAX_SCENARIO:
        raise ScenarioError(
            f"{where}: expected at most {MAX_SCENARIO >> 20} MiB, points included; got {size / (1 << 20):.1f}"
        )
    return scenario


def _apply(raw: dict[str, Any], setting: str) -> None:
    key, equals, text = setting.partition("=")
    if not equals or not key.strip():
        raise ScenarioError(f"--set: expected key=value; got {setting!r}")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        value = text.strip()
    *parents, last = key.strip().split(".")
    table = raw
    for parent in parents:
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            raise ScenarioError(f"--set {key.strip()}: expected the path of a key; {parent} is not a table")
    table[last] = value
