"""The implementations of bodies by name. One is a module of its own, and a line here."""

from collections.abc import Callable

from formation.errors import ScenarioError, unknown
from formation.scenario.scenario import Scenario
from world.bodies.interface import Bodies
from world.bodies.mujoco_ground import MujocoGround
from world.bodies.wheeled import WheeledBodies

IMPLEMENTATIONS: dict[str, Callable[[Scenario], Bodies]] = {
    "wheeled": WheeledBodies,
    "mujoco": lambda scenario: WheeledBodies(scenario, MujocoGround(scenario)),
}


def bodies_for(scenario: Scenario) -> Bodies:
    """The bodies of a scenario's robots at their start.

    Raises:
        ScenarioError: there is no such implementation; the text lists them.
    """
    implementation = scenario.bodies.implementation
    make = IMPLEMENTATIONS.get(implementation)
    if make is None:
        raise ScenarioError(unknown("bodies.implementation", implementation, IMPLEMENTATIONS))
    return make(scenario)
