"""Which controllers there are, by name."""

from agents.leader_follower import Follower, Leader
from agents.nash import Nash
from agents.paper import Paper
from agents.situation import Controller, Pair
from formation.scenario import Scenario


def controller_for(scenario: Scenario, robot: int, pair: Pair) -> Controller:
    """The scenario's controller for one robot; the scenario has checked its name."""
    match scenario.controller.name:
        case "nash":
            return Nash(scenario, robot, pair)
        case "paper":
            return Paper(scenario, robot, pair)
        case "leader_follower":
            return Leader(scenario, robot, pair) if robot == 1 else Follower(scenario, robot, pair)
