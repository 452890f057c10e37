"""A controller of one's own, simulated here and by a process a robot: the same hash."""

import numpy as np

import echelon


class HoldSlot:
    """Every robot drives to its own slot, whatever the others do."""

    def __init__(self, task, options):
        """Of one robot for one episode."""
        self.limits = task.limits

    def plan(self, observation):
        """Correct the slot's own inputs by the error."""
        slot, inputs = observation.reference.slots[0], observation.reference.inputs.copy()
        c, s, (x, y) = np.cos(slot[2]), np.sin(slot[2]), slot[:2] - observation.pose[:2]
        v, turn = inputs[0, 0], np.sin(slot[2] - observation.pose[2])
        inputs[0] += 2 * (c * x + s * y), 2 * turn + 10 * v * (c * y - s * x)
        return echelon.Solution(np.clip(inputs, -self.limits, self.limits))


if __name__ == "__main__":
    scenario = echelon.load("triangle-circle", {"duration": 5}, controller=f"{__file__}:HoldSlot")
    result = echelon.simulate(scenario)
    with echelon.launch(scenario, page=False) as run:
        run.wait()
        print(run.result().trajectory_sha256 == result.trajectory_sha256)
