"""A controller of a user's own, so that its mistakes stop its robot and nothing else.

An exception, a wrong shape, a value that is not finite or beyond ten times the limits: the controller has failed, and
is not asked again in this episode. The agent then commands zero and publishes no plan.
"""

import inspect
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from agents.controllers.interface import Controller, Horizon, Observation, Solution
from agents.controllers.task import Task
from formation.arrays import FloatArray, frozen
from formation.loading.load import failure, folder_of
from formation.loading.source import Source
from formation.scenario.controllers import ControllerOptions

MOST = 10.0
"""Inputs beyond so many times the limits are a mistake; those between are cut to the limits."""


class ControllerFailedError(Exception):
    """A controller of a user's own has failed; the text is one line."""


class Guarded:
    """Asks the controller, and checks what it returns."""

    def __init__(
        self,
        make: Callable[[Task, ControllerOptions], Controller],
        task: Task,
        options: ControllerOptions,
        source: Source,
    ) -> None:
        """Make the controller; a failure is reported by `plan`.

        Args:
            make: the user's class.
            task: of the robot.
            options: its [controller] table.
            source: of the class.
        """
        self._task, self._source, self._class = task, source, make
        self._folder = folder_of(make)
        self._failure = ""
        self._own: Controller | None = None
        try:
            self._own = make(task, options)
        except (Exception, SystemExit) as error:
            self._failure = self._line(failure(error, self._folder))

    def plan(self, observation: Observation) -> Solution:
        """The controller's plan, as a copy.

        Raises:
            ControllerFailedError: it has failed, now or earlier.
        """
        if not self._failure:
            try:
                return self._checked(self._ask(observation))
            except (Exception, SystemExit) as error:
                own = isinstance(error, ControllerFailedError)
                self._failure = self._line(str(error) if own else failure(error, self._folder))
        raise ControllerFailedError(self._failure)

    def _ask(self, observation: Observation) -> object:
        assert self._own is not None
        ahead = self._task.ahead(observation.k)
        reference = Horizon(ahead.slots[:, 0], ahead.inputs[:, 0], ahead.slots[:, 1], ahead.inputs[:, 1])
        shown = observation._replace(limits=self._task.limits, reference=reference)
        return self._own.plan(read_only(shown))

    def _checked(self, solution: object) -> Solution:
        if not isinstance(solution, Solution):
            raise ControllerFailedError(f"expected plan to return a Solution; got {solution!r:.60}{self._place}")
        inputs = self._array("inputs", solution.inputs)
        motion = None if solution.motion is None else self._array("motion", solution.motion)
        return Solution(inputs, converged=bool(solution.converged), motion=motion)

    def _array(self, name: str, given: Any) -> FloatArray:
        if np.iscomplexobj(given := np.asarray(given)):
            raise ControllerFailedError(f"expected real {name}; got complex numbers{self._place}")
        array: FloatArray = np.array(given, dtype=float)
        shape = (self._task.horizon, 2)
        if array.shape != shape:
            raise ControllerFailedError(f"expected {name} of shape {shape}; got {array.shape}{self._place}")
        if not np.isfinite(array).all():
            raise ControllerFailedError(f"expected finite {name}; got {array[~np.isfinite(array)][0]}{self._place}")
        excess = np.abs(array) / self._task.limits
        if excess.max() > MOST:
            raise ControllerFailedError(
                f"expected {name} within {MOST:g} times the limits; got {excess.max():.3g} times{self._place}"
            )
        return frozen(array)

    @property
    def _place(self) -> str:
        """Where its plan is defined."""
        try:
            function = inspect.unwrap(self._class.plan)  # type: ignore[attr-defined]
            code = function.__code__
        except AttributeError:
            return ""
        return f" ({code.co_filename.rpartition('/')[2]}:{code.co_firstlineno})"

    def _line(self, text: str) -> str:
        return f"{self._source.name}: {text}"


def read_only(value: Any) -> Any:
    """The same value with arrays that cannot be written: what is observed is shared with others."""
    if isinstance(value, np.ndarray):
        view = value.view()
        view.flags.writeable = False
        return view
    if isinstance(value, tuple) and hasattr(value, "_make"):
        return value._make(read_only(part) for part in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: read_only(getattr(value, f.name)) for f in fields(value) if f.init})
    return value
