"""Controller `virtual_structure`: every robot follows its own slot of a moving rigid body, and uses no message.

After Lewis and Tan (1997) and Ren and Beard (2004), without formation feedback. It is `nash` without trust: the same
horizon over the same model, limits, reference, estimator and own weight, so that a comparison with `nash` is about
messages only. With `sees` it also holds the edge to the neighbour that it senses, which needs no message either.
"""

from agents.controllers.best_response import BestResponse, Weights
from agents.controllers.interface import options_of
from agents.controllers.task import Task
from formation.scenario.controllers import VirtualStructureOptions
from formation.scenario.scenario import Scenario

SPEED, TURN = 0.01, {False: 0.5, True: 0.4}
"""R of a speed of one spacing per second, and of a turn rate of 1 rad/s, without and with sight: with the second, each
has the jitter of `nash`."""


def make(scenario: Scenario, robot: int, task: Task) -> BestResponse:
    """The controller of one robot."""
    own, spacing = options_of(scenario, VirtualStructureOptions), scenario.spacing
    speed, turn = (own.r[0] * spacing**2, own.r[1]) if own.r else (SPEED, TURN[own.sees])
    return BestResponse(task, spacing, Weights(own.own_weight, speed, turn), None, sources=0)
