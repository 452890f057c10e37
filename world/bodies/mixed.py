"""Simulated bodies and real ones side by side: a real robot is where it says, and its simulated body is put there."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray, read_only
from formation.disturbances import Disturbance
from network.values import NO_PLACES
from world.bodies.sensors import Measured
from world.bodies.wheeled import WheeledBodies


class RealPose(NamedTuple):
    """What is known of a real robot."""

    number: int
    """Of the poses that came in, from 1."""
    pose: FloatArray
    """(3,) [m, m, rad]."""
    velocity: FloatArray
    """(2,) of its wheels [m/s, rad/s]."""


class MixedBodies:
    """The bodies of a team in which some robots are real. Agents do not see the difference.

    A real robot is localised at every tick at which a new pose of it has come in; in between its agent has its
    odometry. What `[bodies]` adds to measurements is added to those of simulated robots only.
    """

    def __init__(
        self, simulated: WheeledBodies, real: Iterable[int], newest: Callable[[int], RealPose | None], age: int
    ) -> None:
        """Robots at their start; a real one that has not been heard of yet at that of the scenario.

        Args:
            simulated: of all robots.
            real: numbers of those that are real.
            newest: what is known of one of them.
            age: ticks from the stamp of a localisation to its arrival, as agents are told.
        """
        self._age = age
        self._simulated, self._real, self._newest = simulated, list(real), newest
        self._told: dict[int, int] = {}
        self._k = 0
        self._place()

    def disturb(self, disturbances: Sequence[Disturbance]) -> None:
        """As WheeledBodies; a real robot is not moved by it."""
        self._simulated.disturb(disturbances)

    def close_over(self, away: Collection[int]) -> None:
        """As WheeledBodies."""
        self._simulated.close_over(away)

    @property
    def poses(self) -> FloatArray:
        """(n, 3) poses now, read-only [m, m, rad]."""
        return self._simulated.poses

    @property
    def odometry(self) -> FloatArray:
        """(n, 2) speeds of the wheels over the last tick [m/s, rad/s]."""
        speeds = self._simulated.odometry.copy()
        for robot in self._real:
            known = self._newest(robot)
            speeds[robot - 1] = known.velocity if known else 0.0
        return read_only(speeds)

    def measure(self) -> Measured | None:
        """What sensors deliver at this tick; called once per tick."""
        self._place()
        seen = self._simulated.measure()
        fresh = {robot: known for robot in self._real if (known := self._news(robot))}
        if seen is None and not fresh:
            return None
        if seen is None:  # the simulated ones are localised more seldom
            seen = Measured(max(0, self._k - self._age), np.zeros_like(self.poses), [], NO_PLACES)
        poses = seen.poses.copy()
        localised = set(seen.localised) - set(self._real)
        for robot, known in fresh.items():
            poses[robot - 1] = known.pose
        return replace(seen, poses=read_only(poses), localised=sorted(localised | fresh.keys()))

    def _news(self, robot: int) -> RealPose | None:
        """The newest pose of a robot, if it has not been delivered yet."""
        known = self._newest(robot)
        if known is None or self._told.get(robot) == known.number:
            return None
        self._told[robot] = known.number
        return known

    def move(self, inputs: FloatArray) -> None:
        """One tick on, under inputs (n, 2) [m/s, rad/s]."""
        self._simulated.move(inputs)
        self._k += 1
        self._place()

    def _place(self) -> None:
        poses = self._simulated.poses.copy()
        for robot in self._real:
            known = self._newest(robot)
            if known is not None:
                poses[robot - 1] = known.pose
        self._simulated.poses = read_only(poses)
