"""Which controllers there are, by name."""

from agents.controllers.consensus import Consensus
from agents.controllers.interface import Controller
from agents.controllers.leader_follower import Follower, Leader
from agents.controllers.nash import Nash
from agents.controllers.pair import Pair
from agents.controllers.paper import Paper
from agents.controllers.virtual_structure import VirtualStructure
from formation.scenario.registry import refusal
from formation.scenario.scenario import Scenario


def controller_for(scenario: Scenario, robot: int, pair: Pair) -> Controller:
    """The scenario's controller for one robot; the scenario has checked its name.

    Raises:
        ScenarioError: the controller plans for all robots in one process, so no single agent can run it.
    """
    match scenario.controller.name:
        case "nash":
            return Nash(scenario, robot, pair)
        case "paper":
            return Paper(scenario, robot, pair)
        case "leader_follower":
            return Leader(scenario, robot, pair) if robot == 1 else Follower(scenario, robot, pair)
        case "virtual_structure":
            return VirtualStructure(scenario, pair)
        case "consensus":
            return Consensus(scenario, pair)
        case "centralised":  # runtime/inprocess.py gives its agents their part in one
            raise refusal("centralised")
