"""Controller `virtual_structure`: every robot follows its own slot of a moving rigid body, and hears nobody.

After Lewis and Tan (1997) and Ren and Beard (2004), without formation feedback. It is `nash` without trust: the same
horizon over the same model, limits, reference, estimator and own weight, so that a comparison with `nash` is about
messages only. With `sees` it also holds the edge to the neighbour that it senses, which needs no message either.
"""

from agents.controllers.best_response import BestResponse, Weights
from agents.controllers.pair import Pair
from formation.scenario.scenario import Scenario

TURN = {False: 0.5, True: 0.4}
"""R of the turn rate, without and with sight: each has then the jitter of `nash`."""


def virtual_structure(scenario: Scenario, pair: Pair) -> BestResponse:
    """The controller of one robot."""
    own = scenario.controller
    speed, turn = own.r or (0.01, TURN[own.sees])
    return BestResponse(pair, scenario.spacing, Weights(own.own_weight, speed, turn), None, sources=0)
