"""The scenarios that a page offers: the user's own, as the run was started, the shipped ones, and those of a folder.

What a user chooses travels to the world as a checked table: the world reads no file that a page names.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from formation.errors import ScenarioError
from formation.scenario.files import load, shipped, table_of
from formation.scenario.scenario import Scenario
from network.control import UseScenario

MAX_FILES = 100
"""Files of a folder that are looked at."""


def use_table(scenario: Scenario) -> UseScenario:
    """The operation that has the world use this very scenario."""
    return UseScenario(scenario=scenario.name, table=scenario.model_dump(mode="json", exclude_unset=True))


class ScenarioList:
    """Labels to choose from, and the operation that each of them stands for."""

    def __init__(self, started: Scenario | None = None, folder: Path | None = None) -> None:
        """A list for one run.

        Args:
            started: the scenario that the run was started with.
            folder: the one that it was started from, whose scenarios are offered.
        """
        self._folder = folder
        self._stamps: dict[Path, tuple[int, int]] = {}
        self._files: dict[str, Path] = {}
        self._loaded: dict[str, Scenario] = {}
        """By label, what is sent as a table."""
        self._shown: tuple[Scenario | None, str] = (None, "")
        if started is not None and not _is_shipped(started):
            self._loaded[f"{started.name} (as started)"] = started
        self._own = tuple(self._loaded)
        self.refresh()

    @property
    def labels(self) -> tuple[str, ...]:
        """The user's own scenario first, then the shipped ones, then the folder's files."""
        return (*self._own, *shipped(), *self._files)

    def refresh(self) -> None:
        """Look at the folder again; a file that has not changed is not read."""
        stamps = {} if self._folder is None else _stamps(self._folder)
        if stamps == self._stamps:
            return
        self._stamps = stamps
        self._files = {file.name: file for file in stamps if _is_scenario(file)}

    def operation(self, label: str) -> UseScenario:
        """What a label stands for; a file is read now.

        Raises:
            ScenarioError: it is not there any more, or wrong; one line per mistake.
        """
        if label in self._files:
            self._loaded[label] = load(str(self._files[label]))
        return use_table(self._loaded[label]) if label in self._loaded else UseScenario(scenario=label)

    def label_of(self, running: Scenario | None, name: str) -> str:
        """The label of what the world runs; its name if it is none of these."""
        if running is not None and running is not self._shown[0]:
            found = (label for label, scenario in self._loaded.items() if _same(scenario, running))
            self._shown = running, next(found, running.name)
        return name if running is None else self._shown[1]


def _same(one: Scenario, other: Scenario) -> bool:
    """Whether they differ in nothing but the controller, which a page chooses by itself."""
    return one.name == other.name and _without_controller(one) == _without_controller(other)


def _without_controller(scenario: Scenario) -> Mapping[str, Any]:
    return scenario.model_dump(mode="json", exclude={"controller"})


def _is_shipped(scenario: Scenario) -> bool:
    return scenario.name in shipped() and load(scenario.name) == scenario


def _stamps(folder: Path) -> dict[Path, tuple[int, int]]:
    """Size and time of change of each TOML file of a folder, in the order of their names."""
    found = {}
    try:
        for file in sorted(one for one in folder.iterdir() if one.suffix.lower() == ".toml" and one.is_file())[
            :MAX_FILES
        ]:
            state = file.stat()
            found[file] = (state.st_size, state.st_mtime_ns)
    except OSError:  # the folder, or a file of it, is gone
        pass
    return found


def _is_scenario(file: Path) -> bool:
    """Whether it looks like one: a folder has other TOML files as well."""
    try:
        return {"name", "path", "formation"} <= set(table_of(file, file.name))
    except ScenarioError:
        return False
