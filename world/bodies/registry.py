"""The implementations of bodies by name. One is a module of its own, and a line here."""

from collections.abc import Callable

from formation.errors import ScenarioError, unknown
from formation.scenario.scenario import Scenario
from world.bodies.interface import Bodies
from world.bodies.unicycle import Plant

IMPLEMENTATIONS: dict[str, Callable[[Scenario], Bodies]] = {
    "unicycle": Plant,
}
DEFAULT = "unicycle"


def bodies_for(scenario: Scenario, implementation: str = DEFAULT) -> Bodies:
    """The bodies of a scenario's robots at their start.

    Raises:
        ScenarioError: there is no such implementation; the text lists them.
    """
    make = IMPLEMENTATIONS.get(implementation)
    if make is None:
        raise ScenarioError(unknown("bodies.implementation", implementation, IMPLEMENTATIONS))
    return make(scenario)
