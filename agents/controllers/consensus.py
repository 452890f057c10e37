"""Controller `consensus`: displacement-based formation control of hand points, fed forward along the reference.

First-order consensus on the formation's errors over the directed ring (Ren and Beard 2008, Distributed Consensus in
Multi-vehicle Cooperative Control; the displacement-based class of Oh, Park and Ahn 2015, A survey of multi-agent
formation control), with hand points and terms to the goal and to the neighbour as Lawton, Beard and Young (2003), A
decentralized approach to formation maneuvers. With z a point at distance L from the axle and r the same in the slot,

    z' = r' - k_g (z - r) - k_f ((z - r) - (z_-i - r_-i)),    (v, L omega) = Rot(-theta) z'

which a unicycle can follow exactly. The errors z - r then obey a linear consensus law, which converges on any graph
that has a spanning tree. Before the first message the neighbour's term is left out.
"""

import numpy as np

from agents.controllers.interface import Observation, Solution, options_of
from agents.controllers.task import Task
from agents.kernels.consensus import roll_law
from formation.scenario.controllers import ConsensusOptions
from formation.scenario.scenario import Scenario


class Consensus:
    """The controller of one robot."""

    def __init__(self, scenario: Scenario, task: Task) -> None:
        """Unless `controller.gain` is given, gains follow from what the robots can do.

        The hand reaches half a spacing. Its slowest direction is sideways, omega_max L: each gain turns an error of
        one spacing into that speed, and both together take away at most a quarter of an
        error per Delta_T, so that sampling and the messages' age leave the law stable.
        """
        self._task = task
        self._reach = scenario.spacing / 2.0
        speed = min(float(task.limits[0]), float(task.limits[1]) * self._reach)
        derived = min(speed / scenario.spacing, 1.0 / (8.0 * task.interval))
        self._gain = options_of(scenario, ConsensusOptions).gain or derived

    def plan(self, observation: Observation) -> Solution:
        task, upstream = self._task, observation.upstream
        slot, targets = task.slot(observation.k, 0)
        other_slot, other_targets = task.slot(observation.k, 1)
        known = upstream.plan is not None
        out = np.empty((task.horizon, 2))
        roll_law(
            observation.pose,
            slot,
            np.ascontiguousarray(targets),
            upstream.pose,
            other_slot,
            np.ascontiguousarray(upstream.inputs),
            np.ascontiguousarray(other_targets),
            self._reach,
            np.array([self._gain, self._gain if known else 0.0]),
            task.interval,
            task.limits,
            out,
        )
        converged = bool(np.isfinite(out).all())  # a peer's plan may hold any finite number
        return Solution(out if converged else np.zeros_like(out), converged)


def make(scenario: Scenario, robot: int, task: Task) -> Consensus:
    """The controller of one robot."""
    return Consensus(scenario, task)
