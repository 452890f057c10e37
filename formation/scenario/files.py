"""Scenarios from files: by name or path, with overrides, every mistake in a line of its own."""

import json
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path as File
from typing import Any

from pydantic import ValidationError

from formation.errors import Line, ScenarioError, unknown
from formation.paths.files import text_of, with_files
from formation.scenario.fitting import factor, scaled, too_narrow, with_limits
from formation.scenario.overrides import DEEPEST, Overrides, from_settings, is_deep, merged
from formation.scenario.scenario import Scenario
from formation.schema import MAX_SCENARIO
from formation.validation import problems

SHIPPED = File(__file__).parents[2] / "scenarios"


def shipped() -> list[str]:
    """Names of the scenarios that come with the project."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


def load(name: str, overrides: Overrides | Iterable[str] = ()) -> Scenario:
    """A scenario by its name or its TOML file, with overrides such as {"link": {"latency": 0.3}}.

    Raises:
        ScenarioError: it does not exist or is wrong; one line per mistake.
    """
    file = File(name)
    beside = is_file(name) and (file.is_file() or file.suffix.lower() == ".toml")  # nothing lies beside a pipe
    return parse(read(name), overrides, where=name, folder=file.parent if beside else File())


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
    return table_of(File(name), name)


def table_of(file: File, where: str) -> dict[str, Any]:
    """The table that a file holds: TOML, or JSON if its name says so.

    Raises:
        ScenarioError: it cannot be read; the text begins with `where`.
    """
    text = text_of(file, where, MAX_SCENARIO)
    form = "JSON" if file.suffix.lower() == ".json" else "TOML"
    try:
        return dict(json.loads(text)) if form == "JSON" else tomllib.loads(text)
    except (TypeError, ValueError, RecursionError) as error:  # what TOML and JSON raise are ValueErrors
        raise ScenarioError(f"{where}: expected {form}; {error}") from None


def is_file(name: str) -> bool:
    """Whether a scenario or study is meant by its file, a pipe as well, and not by its name."""
    return name.lower().endswith((".toml", ".json")) or "/" in name


def _first(lines: list[str]) -> Line:
    """The first line; one that only has text begins with its key."""
    line = lines[0]
    return line if isinstance(line, Line) else Line(line, line.partition(":")[0].removeprefix("file"))


def parse(
    raw: Overrides,
    overrides: Overrides | Iterable[str] = (),
    *,
    where: str = "scenario",
    folder: File | None = None,
) -> Scenario:
    """A scenario from its raw table, with overrides: nested, or settings such as link.latency=0.3.

    Args:
        raw: the table.
        overrides: of it.
        where: what errors begin with.
        folder: in which files that it names are sought; without it no file is read.

    Raises:
        ScenarioError: one line per mistake.
    """
    if not isinstance(overrides, Mapping):
        overrides = from_settings(overrides)
    if is_deep(raw) or is_deep(overrides):
        raise ScenarioError(f"{where}: expected tables, at most {DEEPEST} within each other; got more")
    table = merged(raw, overrides)
    if folder is not None:
        table = with_files(table, folder, where)
    table = with_limits(table)
    try:
        scenario = Scenario.model_validate(table)
        if (by := factor(scenario)) > 1.0:
            if scenario.bodies.fit == "refuse":
                raise ScenarioError(f"{where}: {too_narrow(scenario, by)}")
            scenario = Scenario.model_validate(scaled(scenario, by))
    except ValidationError as error:
        found = problems(error, Scenario)
        lines = [line.removeprefix("file: ") for line in found]
        raise ScenarioError("\n".join(f"{where}: {line}" for line in lines), of=_first(found)) from None
    size = len(scenario.model_dump_json(exclude_unset=True))
    if size > MAX_SCENARIO:
        raise ScenarioError(
            f"{where}: expected at most {MAX_SCENARIO >> 20} MiB, points included; got {size / (1 << 20):.1f}"
        )
    return scenario
