"""How each controller is made, by name. A controller is a module of its own, and a line here.

formation/scenario/registry.py has the options and the spec of each of these names.
"""

from collections.abc import Callable

from agents.controllers.centralised import Team
from agents.controllers.consensus import Consensus
from agents.controllers.interface import Controller
from agents.controllers.leader_follower import Follower, Leader
from agents.controllers.nash import Nash
from agents.controllers.pair import Pair
from agents.controllers.paper import Paper
from agents.controllers.virtual_structure import VirtualStructure
from formation.scenario.registry import refusal
from formation.scenario.scenario import Scenario

Make = Callable[[Scenario, int, Pair], Controller]
MAKES: dict[str, Make] = {
    "nash": Nash,
    "paper": Paper,
    "leader_follower": lambda scenario, robot, pair: (Leader if robot == 1 else Follower)(scenario, robot, pair),
    "virtual_structure": lambda scenario, _, pair: VirtualStructure(scenario, pair),
    "consensus": lambda scenario, _, pair: Consensus(scenario, pair),
}
"""Of one robot, its number and its pair."""
TEAMS: dict[str, Callable[[Scenario], Team]] = {"centralised": Team}
"""Of all robots at once; runtime/inprocess.py gives each agent its part."""


def controller_for(scenario: Scenario, robot: int, pair: Pair) -> Controller:
    """The scenario's controller for one robot; the scenario has checked its name.

    Raises:
        ScenarioError: the controller is one for all robots, which no robot can have for itself.
    """
    make = MAKES.get(scenario.controller.name)
    if make is None:
        raise refusal(scenario.controller.name)
    return make(scenario, robot, pair)


def team_for(scenario: Scenario) -> Team | None:
    """The scenario's controller for all robots at once; None if each robot has its own."""
    make = TEAMS.get(scenario.controller.name)
    return make(scenario) if make else None
