"""The bodies: unicycles that slip, get stuck and are pushed, and noisy localisation (docs/theory.md, section 9)."""

import numpy as np

from formation import unicycle
from formation.arrays import FloatArray, frozen
from formation.disturbances import Disturbance
from formation.scenario.scenario import Scenario


class Plant:
    """Poses of all robots, moved tick by tick. The same seed gives the same noise, whatever the inputs."""

    def __init__(self, scenario: Scenario) -> None:
        self._limits = scenario.robots.limits
        self._noise = scenario.noise
        self._dt = scenario.control_interval
        self._disturbances = scenario.disturbances
        self._k = 0
        self._slips = scenario.noise.slip > 0.0 or scenario.noise.gyro > 0.0
        self._blurs = scenario.noise.position > 0.0 or scenario.noise.heading > 0.0
        # Two streams, so that switching one kind of noise on does not change the draws of the other.
        self._slip_draws = np.random.Generator(np.random.Philox(key=[scenario.seed, 2]))
        self._blur_draws = np.random.Generator(np.random.Philox(key=[scenario.seed, 3]))
        self.poses: FloatArray = scenario.start_poses()
        """(n, 3) true poses now, read-only [m, m, rad]."""

    def measure(self) -> FloatArray:
        """Poses (n, 3) as localisation sees them; every call draws anew."""
        if not self._blurs:
            return self.poses
        spread = np.array([self._noise.position, self._noise.position, self._noise.heading])
        return frozen(self.poses + spread * self._blur_draws.standard_normal(self.poses.shape))

    def move(self, inputs: FloatArray) -> None:
        """One tick on, under inputs (n, 2) held within the limits [m/s, rad/s]."""
        v = np.clip(inputs[:, 0], -self._limits.v, self._limits.v)
        omega = np.clip(inputs[:, 1], -self._limits.omega, self._limits.omega)
        if self._slips:
            n = self._slip_draws.standard_normal((len(inputs), 3))
            v = v * (1.0 + self._noise.slip * n[:, 0])
            omega = omega * (1.0 + self._noise.slip * n[:, 1]) + self._noise.gyro * n[:, 2]
        if self._disturbances:
            v, omega = self._held_back(v, omega)
        moved = [
            unicycle.step(x, y, theta, a, b, self._dt)
            for (x, y, theta), a, b in zip(self.poses.tolist(), v.tolist(), omega.tolist(), strict=True)
        ]
        self.poses = frozen(moved + self._dt * self._drift() if self._disturbances else moved)
        self._k += 1

    def _held_back(self, v: FloatArray, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The inputs (n,) each, reduced for robots that are slowed or stuck."""
        share = np.ones(len(v))
        for entry in self._acting():
            share[entry.robot - 1] *= entry.drive
        return v * share, omega * share

    def _drift(self) -> FloatArray:
        """Velocities (n, 3) with which robots are pushed."""
        drift = np.zeros_like(self.poses)
        for entry in self._acting():
            drift[entry.robot - 1] += entry.drift
        return drift

    def _acting(self) -> list[Disturbance]:
        return [entry for entry in self._disturbances if entry.on(self._k * self._dt)]
