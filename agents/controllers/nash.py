"""Controller `nash`: a best response to the neighbours along the edges, or the paper's game of a pair."""

from agents.controllers.best_response import BestResponse, Weights
from agents.controllers.interface import Controller, options_of
from agents.controllers.pair_game import PairNash
from agents.controllers.task import Task
from agents.controllers.waiting import Waiting
from formation.scenario.controllers import NashOptions
from formation.scenario.scenario import Scenario

TRUST_TIME = {"upstream": 0.3, "both": 0.5}
"""Time constant with which trust fades with a plan's age, by whose plans are heard [s]."""
SPEED, TURN = 0.01, 0.4
"""R of a speed of one spacing per second, and of a turn rate of 1 rad/s, beyond the slot's."""


def make(scenario: Scenario, robot: int, task: Task) -> Controller:
    """The controller of one robot."""
    own, spacing = options_of(scenario, NashOptions), scenario.spacing
    if own.game == "pair":
        return PairNash(scenario, robot, task)
    trust = own.trust_time or TRUST_TIME[own.hears]
    speed, turn = (own.r[0] * spacing**2, own.r[1]) if own.r else (SPEED, TURN)
    waits = Waiting(task) if own.waits else None
    sources = 2 if own.hears == "both" else 1
    return BestResponse(task, spacing, Weights(own.own_weight, speed, turn, trust), waits, sources=sources)
