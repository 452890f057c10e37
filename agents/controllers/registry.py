"""How each controller is made, by name. A controller is a module of its own, and a line here.

formation/scenario/registry.py has the options and the spec of each of these names.
"""

from collections.abc import Callable

from agents.controllers.centralised import Team
from agents.controllers.consensus import Consensus
from agents.controllers.interface import Controller
from agents.controllers.leader_follower import Follower, Leader
from agents.controllers.nash import nash
from agents.controllers.paper import Paper
from agents.controllers.task import Task
from agents.controllers.virtual_structure import virtual_structure
from formation.errors import ScenarioError
from formation.loading.load import differs
from formation.scenario.registry import refusal, spec_of
from formation.scenario.scenario import Scenario

Make = Callable[[Scenario, int, Task], Controller]
MAKES: dict[str, Make] = {
    "nash": nash,
    "paper": Paper,
    "leader_follower": lambda scenario, robot, task: (Leader if robot == 1 else Follower)(scenario, robot, task),
    "virtual_structure": lambda scenario, _, task: virtual_structure(scenario, task),
    "consensus": lambda scenario, _, task: Consensus(scenario, task),
}
"""Of one robot, its number and its pair."""
TEAMS: dict[str, Callable[[Scenario], Team]] = {"centralised": Team}
"""Of all robots at once; runtime/inprocess.py gives each agent its part."""


def controller_for(scenario: Scenario, robot: int, task: Task) -> Controller:
    """The scenario's controller for one robot; the scenario has checked its name.

    Raises:
        ScenarioError: the controller is one for all robots, which no robot can have for itself, or a user's own that is
            not loaded here.
    """
    make = MAKES.get(scenario.controller.name)
    code = spec_of(scenario.controller).code
    if make is None and code is not None:
        raise ScenarioError(differs(code.kind, code.name, code.origin, code.sha256, None))
    if make is None:
        raise refusal(scenario.controller.name)
    return make(scenario, robot, task)


def team_for(scenario: Scenario) -> Team | None:
    """The scenario's controller for all robots at once; None if each robot has its own."""
    make = TEAMS.get(scenario.controller.name)
    return make(scenario) if make else None
