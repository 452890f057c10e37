"""Bodies of one's own: pucks that glide on with a part of their speed, and a formation on top of them."""

import numpy as np

import echelon


class Puck:
    """Every robot's motion, and how it is seen: exactly, at every tick."""

    def __init__(self, scenario):
        """Robots at their start, at rest."""
        self.dt, self.poses = scenario.control_interval, np.array(scenario.start_poses())
        self.glide = np.zeros((scenario.size, 2))

    def measure(self):
        """Poses (n, 3) [m, m, rad]."""
        return self.poses

    def move(self, inputs):
        """One tick on, under inputs (n, 2) [m/s, rad/s]."""
        self.glide = 0.8 * self.glide + 0.2 * inputs
        theta, (v, omega) = self.poses[:, 2], self.glide.T
        self.poses = self.poses + self.dt * np.stack([v * np.cos(theta), v * np.sin(theta), omega], axis=1)


if __name__ == "__main__":
    scenario = echelon.load("triangle-circle", {"duration": 20}, bodies=f"{__file__}:Puck")
    result = echelon.simulate(scenario)
    print(f"largest distance error after 15 s: {1e3 * abs(result.distance_errors[1500:]).max():.2f} mm")
