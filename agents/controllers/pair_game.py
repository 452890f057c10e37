"""`nash` with `game = "pair"`: robot i plays the pair's game on the exact model, its own part of the equilibrium.

docs/theory.md, section 5. One Gauss-Newton step per plan, warm-started from the own last plan and the aged plan of the
neighbour; both players are improved, only the own half is kept and sent.
"""

import math

import numpy as np

from agents.controllers.interface import Observation, Solution
from agents.controllers.pair_waiting import PairWaiting
from agents.controllers.task import Task
from agents.kernels.pair_cost import cost, improve
from agents.kernels.unicycle import shift
from formation.arrays import FloatArray
from formation.scenario.controllers import NashOptions, PairGame
from formation.scenario.scenario import Scenario

PLACE = 30.0
"""Cost of a position error of one spacing."""
HEADING = 1.0
"""Cost of a heading error of one radian."""
SPEED = 0.01
"""Cost of a speed of one spacing per second beyond the reference's."""
TURN = 1.0
"""Cost of a turn rate of one radian per second beyond the reference's."""
FROZEN = 1e12
"""Weight on the neighbour's inputs that keeps them as they are, for a best response to its plan."""


def pair_game(scenario: Scenario) -> PairGame:
    """The scenario's own options of the pair's game; the default ones if its controller plays another."""
    own = scenario.controller
    return own if isinstance(own, PairGame) else NashOptions()


def weights(scenario: Scenario) -> tuple[list[float], list[float]]:
    """Diagonals of Q (6,) and R (2,), derived from the scenario unless it gives its own.

    Lengths count in spacings, so that a formation twice as large on paths twice as large behaves the same; the
    pattern counts `controller.formation` times as much as the path.
    """
    own, place = pair_game(scenario), PLACE / scenario.spacing**2
    pattern = own.formation * place
    # The tangential weight is divided by the pair's own distance squared: it is that of an angle.
    q = [place, place, HEADING, pattern, own.formation * PLACE, HEADING]
    return own.q or q, own.r or [SPEED / scenario.spacing**2, TURN]


class Game:
    """The pair's game: its costs, and steps towards its equilibrium."""

    def __init__(self, scenario: Scenario, robot: int, task: Task) -> None:
        q, r = weights(scenario)
        self._task = task
        self._q, self._r = np.array(q, dtype=float), np.array([*r, *r], dtype=float)
        self._r_frozen = np.array([*r, FROZEN, FROZEN])

    def improve(self, k: int, poses: FloatArray, inputs: FloatArray) -> tuple[FloatArray, float]:
        """Inputs (N, 4) of both players after one step from `inputs`, and the largest change (NaN: it failed)."""
        return self._improve(k, poses, inputs, self._r, None)

    def gap(self, k: int, poses: FloatArray, inputs: FloatArray) -> float:
        """Nash gap of the robot: how much it could lower J_i alone (docs/theory.md, section 5).

        Args:
            k: tick.
            poses: (6,) of robot i and its neighbour.
            inputs: (N, 4) that both play.
        """
        frozen_targets = self._task.ahead(k).pair[1]
        frozen_targets[:, 1] = inputs[:, 2:]
        best = inputs
        for _ in range(3):
            best, change = self._improve(k, poses, best, self._r_frozen, frozen_targets)
            if not math.isfinite(change):
                return 0.0
        best = np.hstack([best[:, :2], inputs[:, 2:]])
        return max(0.0, self._cost(k, poses, inputs) - self._cost(k, poses, best))

    def _improve(
        self, k: int, poses: FloatArray, inputs: FloatArray, r: FloatArray, targets: FloatArray | None
    ) -> tuple[FloatArray, float]:
        out = np.empty_like(inputs)
        change = improve(poses, inputs, *self._problem(k, targets), r, self._task.limits, out)
        return out, change

    def _cost(self, k: int, poses: FloatArray, inputs: FloatArray) -> float:
        return float(cost(poses, inputs, *self._problem(k, None), self._r))

    def _problem(self, k: int, targets: FloatArray | None) -> tuple[object, ...]:
        """Arguments of both kernels for the task at tick k, in their order: slots, targets, dt, q."""
        slots, inputs = self._task.ahead(k).pair
        return slots, inputs if targets is None else targets, self._task.interval, self._q


class PairNash:
    """The controller of one robot."""

    def __init__(self, scenario: Scenario, robot: int, task: Task, *, waits: bool | None = None) -> None:
        """The controller at the start.

        Args:
            scenario, robot, task: what to do.
            waits: whether it waits for robots that cannot keep up; if absent, the scenario decides.
        """
        self._task, self._game = task, Game(scenario, robot, task)
        waits = pair_game(scenario).waits if waits is None else waits
        self._waiting = PairWaiting(task, scenario.spacing) if waits else None
        self._last: tuple[int, FloatArray] | None = None

    def plan(self, observation: Observation) -> Solution:
        task, k = self._task, observation.k
        if self._waiting:
            self._waiting.update(k, observation.pose, observation.upstream.plan)
        _, target = task.slot(k, 0)
        nominal = np.empty((task.horizon, 4))
        if self._last is None:
            nominal[:, :2] = target
        else:
            made, inputs = self._last
            shift(inputs, (k - made) * task.tick, task.interval, target, nominal[:, :2])
        nominal[:, 2:] = observation.upstream.inputs
        poses = np.concatenate([observation.pose, observation.upstream.pose])
        inputs, change = self._game.improve(k, poses, nominal)
        converged = math.isfinite(change)
        own = np.ascontiguousarray((inputs if converged else nominal)[:, :2])
        if not converged:
            own = np.clip(np.nan_to_num(own), -task.limits, task.limits)
        self._last = (k, own)
        if self._waiting:
            self._waiting.planned(observation.pose, own)
        return Solution(own, converged, task.lag, self._waiting.lag_rate if self._waiting else 0.0)
