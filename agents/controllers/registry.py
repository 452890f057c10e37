"""How a controller is made: the module of its name has a function `make`, or `Team` for one that plans for all robots.

A process loads the controllers that it uses, and no others: their kernels take tens of milliseconds each.
formation/scenario/registry.py has the options and the spec of each name.
"""

import importlib
from typing import Any, cast

from agents.controllers.interface import Controller, Team
from agents.controllers.task import Task
from formation.scenario.registry import IN_PROCESS, refusal
from formation.scenario.scenario import Scenario


def controller_for(scenario: Scenario, robot: int, task: Task) -> Controller:
    """The scenario's controller for one robot; the scenario has checked its name.

    Raises:
        ScenarioError: the controller is one for all robots, which no robot can have for itself.
    """
    name = scenario.controller.name
    if name in IN_PROCESS:
        raise refusal(name)
    return cast(Controller, _module(name).make(scenario, robot, task))


def team_for(scenario: Scenario) -> Team | None:
    """The scenario's controller for all robots at once; None if each robot has its own."""
    name = scenario.controller.name
    return cast(Team, _module(name).Team(scenario)) if name in IN_PROCESS else None


def _module(name: str) -> Any:
    return importlib.import_module(f"agents.controllers.{name}")
