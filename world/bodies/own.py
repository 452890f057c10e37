"""Bodies of users' own: what is expected of a class, and how one gets its place among the implementations.

A class `Name(scenario)` with `poses`, `measure()` and `move(inputs)`; optionally `odometry`.
"""

from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from formation.arrays import FloatArray, frozen
from formation.errors import ScenarioError
from formation.loading.load import failure, folder_of, load, unpack
from formation.loading.source import Source, admitted, loaded
from formation.scenario.registry import own_controllers
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import UserCode
from network.values import NO_PLACES
from world.bodies.registry import IMPLEMENTATIONS
from world.bodies.sensors import Measured

NEEDED = ("poses", "measure", "move")
BUILT_IN = tuple(IMPLEMENTATIONS)


class OwnBodies:
    """Bodies that a user's class moves. A mistake of the class ends the episode with one line."""

    def __init__(self, make: Callable[[Scenario], Any], scenario: Scenario, source: Source) -> None:
        self._source, self._size, self._k = source, scenario.size, 0
        self._folder = folder_of(make)
        self._own: Any = self._call(lambda: make(scenario))
        self._inputs: FloatArray = np.zeros((scenario.size, 2))
        self._closed = False
        self.poses = self._poses()
        """(n, 3) true poses now, read-only [m, m, rad]."""

    @property
    def odometry(self) -> FloatArray:
        """(n, 2) speeds of the wheels over the last tick [m/s, rad/s]; the commands, if the class does not tell."""
        if not hasattr(self._own, "odometry"):
            return frozen(self._inputs)
        return self._array("odometry", self._own.odometry, 2)

    def close_over(self, away: Collection[int]) -> None:
        """The class may have a method for it; else nobody sees a neighbour while a robot is away."""
        self._closed = bool(away) and not hasattr(self._own, "close_over")
        if not self._closed and hasattr(self._own, "close_over"):
            self._call(lambda: self._own.close_over(away))

    def measure(self) -> Measured | None:
        """What sensors deliver at this tick: poses (n, 3), nothing, or a Measured."""
        found = self._call(self._own.measure)
        if found is None:
            return None
        if isinstance(found, Measured):
            relatives = NO_PLACES if self._closed else found.relatives
            seen: Measured = self._call(lambda: replace(found, poses=frozen(found.poses), relatives=frozen(relatives)))
            return seen
        robots = list(range(1, self._size + 1))
        return Measured(self._k, self._array("what measure returns", found, 3), robots, NO_PLACES)

    def move(self, inputs: FloatArray) -> None:
        """One tick on, under inputs (n, 2) [m/s, rad/s]."""
        self._inputs = inputs
        self._call(lambda: self._own.move(frozen(inputs)))
        self.poses = self._poses()
        self._k += 1

    def _poses(self) -> FloatArray:
        return self._array("poses", self._call(lambda: self._own.poses), 3)

    def _array(self, name: str, values: ArrayLike, columns: int) -> FloatArray:
        given = self._call(lambda: np.asarray(values))
        if np.iscomplexobj(given):
            raise self._error(f"expected real {name}; got complex numbers")
        array = frozen(self._call(lambda: given.astype(float)))
        if array.shape != (self._size, columns) or not np.isfinite(array).all():
            finite = "finite " if array.shape == (self._size, columns) else ""
            raise self._error(f"expected {finite}{name} of shape {(self._size, columns)}; got {array.tolist()!r:.80}")
        return array

    def _call(self, what: Callable[[], Any]) -> Any:
        try:
            return what()
        except (Exception, SystemExit) as error:
            raise self._error(failure(error, self._folder)) from None

    def _error(self, text: str) -> ScenarioError:
        return ScenarioError(f"bodies {self._source.name}: {text}")


def load_bodies(spec: str) -> Source:
    """Load what a command line or an API call names, and add it to the implementations.

    Raises:
        ScenarioError: it cannot be had, or is not what is expected of bodies; one line.
    """
    return _admit(*load(spec, "bodies"))


def admit(source: Source) -> Source:
    """Load and add what was read elsewhere or earlier. Raises ScenarioError."""
    return _admit(*unpack(source))


def _admit(source: Source, found: type) -> Source:
    absent = [name for name in NEEDED[1:] if not callable(getattr(found, name, None))]
    if absent:
        has = [name for name in vars(found) if not name.startswith("_")]
        raise ScenarioError(
            f"{source.origin}: expected poses, measure() and move(inputs); it has {', '.join(has) or 'none of them'}"
        )
    if source.attribute in BUILT_IN:
        raise ScenarioError(
            f"--bodies: expected a class with a name of its own; got {source.attribute}, which is built in"
        )
    source = admitted(source)
    IMPLEMENTATIONS[source.name] = lambda scenario: OwnBodies(found, scenario, source)
    return source


def user_code() -> list[UserCode]:
    """All code of users' own that this process knows."""
    found = [UserCode(kind="bodies", name=s.name, origin=s.origin, sha256=s.sha256) for s in loaded("bodies").values()]
    return [*own_controllers(), *found]


def user_code_of(scenario: Scenario) -> list[UserCode]:
    """What of a scenario is code of a user's own."""
    used = {("controller", scenario.controller.name), ("bodies", scenario.bodies.implementation)}
    return [code for code in user_code() if (code.kind, code.name) in used]
