"""The bodies: unicycles with wheel slip, and the noisy localisation that agents get (THEORY section 5)."""

import numpy as np

from formation import unicycle
from formation.arrays import FloatArray, frozen
from formation.scenario import Scenario


class Plant:
    """Poses of all robots, moved tick by tick. The same seed gives the same noise, whatever the inputs."""

    def __init__(self, scenario: Scenario) -> None:
        self._limits = scenario.robots.limits
        self._noise = scenario.noise
        self._dt = scenario.control_interval
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
        moved = [
            unicycle.step(x, y, theta, a, b, self._dt)
            for (x, y, theta), a, b in zip(self.poses.tolist(), v.tolist(), omega.tolist(), strict=True)
        ]
        self.poses = frozen(moved)
