"""Controller `leader_follower`: the paper's baseline (section 4, after Chen et al. 2010), erratum 11 mended.

`controller.misprints` brings erratum 11 back; `controller.errata` mends number 13, a term that the law lacks.

Robot 1 leads; every other robot steers to its place beside the robot whose plan it receives.
"""

import math

import numpy as np

from agents.controllers.interface import Observation, Solution, options_of
from agents.controllers.pair_game import PairNash
from agents.controllers.task import Task
from formation.arrays import FloatArray
from formation.pattern import rotate
from formation.scenario.controllers import LeaderFollowerOptions
from formation.scenario.scenario import Scenario
from formation.unicycle import wrap


class Follower:
    """A Lyapunov-based law: the leader's own velocity, corrected by the place's error in the follower's frame."""

    def __init__(self, scenario: Scenario, robot: int, task: Task) -> None:
        self._task = task
        own = options_of(scenario, LeaderFollowerOptions)
        self._gain_x, self._gain_theta = own.gains
        self._misprinted, self._mended = 11 in own.misprints, 13 in own.errata

    def plan(self, observation: Observation) -> Solution:
        leader, pose = observation.upstream, observation.pose
        v_l, omega_l = (float(leader.inputs[0, 0]), float(leader.inputs[0, 1])) if leader.plan else (0.0, 0.0)
        theta_l = float(leader.pose[2])
        place = self._place(observation.k)
        gap = leader.pose[:2] + rotate(np.array(theta_l), place) - pose[:2]
        e_x, e_y = rotate(np.array(-pose[2]), gap)
        if self._mended:  # the place turns with the leader: its own speed and heading, not the leader's
            ahead, aside = v_l - omega_l * float(place[1]), omega_l * float(place[0])
            v_l = math.copysign(math.hypot(ahead, aside), ahead)
            theta_l += math.atan2(math.copysign(1.0, ahead) * aside, abs(ahead))
        e_theta = wrap(theta_l - float(pose[2]))
        if self._misprinted:  # sin(e_theta) / e_y: the factor e_y cancels
            e_y = np.float64(e_theta)
        ratio = math.sin(e_theta) / e_theta if abs(e_theta) > 1e-9 else 1.0
        v = v_l * math.cos(e_theta) + self._gain_x * float(e_x)
        omega = omega_l + self._gain_theta * e_theta + v_l * float(e_y) * ratio
        converged = math.isfinite(v) and math.isfinite(omega)  # a peer's plan may hold any finite number
        wished = np.array([v, omega]) if converged else np.zeros(2)
        now = np.clip(wished, -self._task.limits, self._task.limits)
        return Solution(np.tile(now, (self._task.horizon, 1)), converged)

    def _place(self, k: int) -> FloatArray:
        """Where the robot belongs beside its leader, in the leader's frame (2,) [m]."""
        own, other = self._task.offsets(k)
        place: FloatArray = own - other
        return place


class Leader:
    """Robot 1, or the next that has not left: `nash` with a neighbour in its slot, so that it waits for no robot."""

    def __init__(self, scenario: Scenario, robot: int, task: Task) -> None:
        self._task, self._nash = (
            task,
            PairNash(scenario, robot, task, waits=options_of(scenario, LeaderFollowerOptions).waits),
        )  # it waits for no robot: it uses no plan

    def plan(self, observation: Observation) -> Solution:
        slot, tail = self._task.slot(observation.k, 1)
        alone = type(observation.upstream)(slot, tail, None)
        return self._nash.plan(Observation(observation.k, observation.pose, alone))


def make(scenario: Scenario, robot: int, task: Task) -> Leader | Follower:
    """The controller of one robot."""
    return (Leader if robot == task.first else Follower)(scenario, robot, task)
