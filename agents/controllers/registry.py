"""How a controller is made: the module of its name has a function `make`, or `Team` for one that plans for all robots.

A process loads the controllers that it uses, and no others: their kernels take tens of milliseconds each.
formation/scenario/registry.py has the options and the spec of each name.
"""

import importlib
from collections.abc import Callable
from typing import Any, cast

from agents.controllers.interface import Controller, Team
from agents.controllers.task import Task
from formation.errors import ScenarioError
from formation.loading.load import differs
from formation.scenario.registry import IN_PROCESS, refusal, spec_of
from formation.scenario.scenario import Scenario

OWN: dict[str, Callable[[Scenario, int, Task], Controller]] = {}
"""How controllers of users' own are made that are loaded here."""


def controller_for(scenario: Scenario, robot: int, task: Task) -> Controller:
    """The scenario's controller for one robot; the scenario has checked its name.

    Raises:
        ScenarioError: the controller is one for all robots, which no robot can have for itself, or a user's own that is
            not loaded here.
    """
    name, code = scenario.controller.name, spec_of(scenario.controller).code
    if name in IN_PROCESS:
        raise refusal(name)
    if code is None:
        return cast(Controller, _module(name).make(scenario, robot, task))
    if name not in OWN:
        raise ScenarioError(differs(code.kind, code.name, code.origin, code.sha256, None))
    return OWN[name](scenario, robot, task)


def team_for(scenario: Scenario) -> Team | None:
    """The scenario's controller for all robots at once; None if each robot has its own."""
    name = scenario.controller.name
    return cast(Team, _module(name).Team(scenario)) if name in IN_PROCESS else None


def _module(name: str) -> Any:
    return importlib.import_module(f"agents.controllers.{name}")
