"""What messages can buy at all: the best linear law of all robots together, beside `nash` and no messages.

python -m benchmarks.limit [--rows A,D] [--seeds 1000:1002] [--json]

The robots' errors along, across and in heading, each in its slot's frame, are one linear system; its law minimises
l_e^2 of all pairs + place |e|^2 + inputs (discrete Riccati equation at the planning interval). It is driven in the same
simulation, with the same estimators and compensation as the others, and knows every robot's estimate of the plan
before. The weights are swept; of those whose jitter is at most that of `nash` the least error is the limit
(docs/theory.md, section 10). It supposes a formation that moves as a rigid body at constant speed, as in these rows.
"""

import argparse
import itertools
import json
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from agents.controllers.interface import Controller, Observation, Solution
from agents.controllers.task import Task
from benchmarks.bodies import names_of, seeds_of
from benchmarks.bodies_cells import Cell, commit
from benchmarks.bodies_rows import DEAF, ROWS
from experiments.trials.code_version import code_version
from experiments.trials.pool import cores, local
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation
from runtime.precompile import ensure_compiled

SPEED_WEIGHTS = (1e-3, 3e-3, 1e-2, 3e-2, 1e-1)
"""Of (v - v_r)^2 against l_e^2 [s^2]."""
TURN_WEIGHTS = (0.3, 1.0, 3.0, 10.0)
"""Of (omega - omega_r)^2, in units of 3.3e-5 m^2 s^2 (that of `nash`)."""
PLACE_WEIGHTS = (0.1, 0.3)
"""Of |e|^2 against l_e^2."""
TURN_UNIT = 3.3e-5
RIGID = 1e-6
"""How much the slots' relative places may change along the path [m, rad]."""


class Weights(NamedTuple):
    """One point of the sweep."""

    speed: float
    turn: float
    place: float


class Joint:
    """The law of all robots, from plan to plan."""

    def __init__(self, scenario: Scenario, weights: Weights) -> None:
        self.tasks = [Task(scenario, robot) for robot in range(1, scenario.size + 1)]
        self.errors = np.zeros((scenario.size, 3))
        """(n, 3) of the newest estimates: along, across [m], heading [rad]."""
        step = scenario.controller.plan_every * scenario.control_interval
        a, b, c = self._system(0)
        later = self._system(round(5.0 / scenario.control_interval))
        if any(np.abs(now - then).max() > RIGID for now, then in zip((a, b, c), later, strict=True)):
            raise SystemExit("expected a formation that moves as a rigid body at constant speed")
        n = scenario.size
        whole = expm(np.block([[a, b], [np.zeros((2 * n, 5 * n))]]) * step)
        a, b = whole[: 3 * n, : 3 * n], whole[: 3 * n, 3 * n :]
        q = c.T @ c + weights.place * np.kron(np.eye(n), np.diag([1.0, 1.0, 0.0]))
        r = np.kron(np.eye(n), np.diag([weights.speed, weights.turn]))
        p = solve_discrete_are(a, b, q, r)
        self.gain: FloatArray = np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a)
        """(2 n, 3 n)."""

    def _system(self, k: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """A (3n, 3n) and B (3n, 2n) of the errors' motion at tick k, and C (n, 3n) of every pair's l_e."""
        n = len(self.tasks)
        a, b, c = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, 2 * n)), np.zeros((n, 3 * n))
        slots = [task.slot(k, 0)[0] for task in self.tasks]
        for i, task in enumerate(self.tasks):
            v, omega = task.slot(k, 0)[1][0]
            row = 3 * i
            a[row, row + 1], a[row + 1, row], a[row + 1, row + 2] = omega, -omega, v
            b[row, 2 * i] = b[row + 2, 2 * i + 1] = 1.0
            other = (i - 1) % n
            to = slots[other][:2] - slots[i][:2]
            to /= np.hypot(*to)
            for robot, sign in ((i, 1.0), (other, -1.0)):
                theta = slots[robot][2]
                ahead, left = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
                c[i, 3 * robot : 3 * robot + 2] = sign * to @ ahead, sign * to @ left
        return a, b, c

    def inputs(self, robot: int, observation: Observation) -> FloatArray:
        """(2,) body velocities of a robot, by its own estimate and the others' newest."""
        slot, tail = self.tasks[robot - 1].slot(observation.k, 0)
        away, theta = observation.pose[:2] - slot[:2], slot[2]
        turned = observation.pose[2] - theta
        self.errors[robot - 1] = (
            away[0] * np.cos(theta) + away[1] * np.sin(theta),
            away[1] * np.cos(theta) - away[0] * np.sin(theta),
            np.arctan2(np.sin(turned), np.cos(turned)),
        )
        law: FloatArray = tail[0] - self.gain[2 * robot - 2 : 2 * robot] @ self.errors.ravel()
        return np.clip(law, -self.tasks[0].limits, self.tasks[0].limits)


class Member:
    """One robot's part of the joint law."""

    def __init__(self, joint: Joint, robot: int) -> None:
        self._joint, self._robot = joint, robot

    def plan(self, observation: Observation) -> Solution:
        """The same inputs over the whole horizon: the next plan comes first."""
        steps = self._joint.tasks[0].horizon
        return Solution(np.tile(self._joint.inputs(self._robot, observation), (steps, 1)))


class JointTeam:
    """What runtime/inprocess.py asks of a controller of all robots; it is shown true poses and does not look."""

    lag = 0.0

    def __init__(self, scenario: Scenario, weights: Weights) -> None:
        self._joint = Joint(scenario, weights)

    def see(self, k: int, poses: FloatArray, speeds: FloatArray, commands: FloatArray) -> None:
        """What is true; not used."""

    def reshape(self, scenario: Scenario, k: int) -> None:
        """The law is of one shape."""
        raise NotImplementedError

    def member(self, robot: int) -> Controller:
        """One robot's part."""
        return Member(self._joint, robot)


@dataclass(frozen=True, slots=True)
class LimitCell(Cell):
    """A simulation under the joint law."""

    weights: Weights

    @property
    def name(self) -> str:
        return f"{self.row}, joint law, seed {self.seed}, {self.weights}"

    def simulation(self) -> Simulation:
        scenario = self.scenario()
        return Simulation(scenario, team=JointTeam(scenario, self.weights))


def limit_of(row: str, seeds: range, workers: int) -> dict[str, Any]:
    """Error and jitter of `nash`, of no messages, and of the joint law with the best weights within the jitter."""
    sweep = [Weights(v, TURN_UNIT * w, e) for v, w, e in itertools.product(SPEED_WEIGHTS, TURN_WEIGHTS, PLACE_WEIGHTS)]
    rivals: dict[str, list[Cell]] = {
        name: [Cell(row, "on time", name, seed) for seed in seeds] for name in ("nash", DEAF)
    }
    swept: dict[Weights, list[Cell]] = {
        weights: [LimitCell(row, "on time", "nash", seed, weights) for seed in seeds] for weights in sweep
    }
    work = [cell for cells in (*rivals.values(), *swept.values()) for cell in cells]
    done = {piece.name: result for piece, result in local(workers)(work)}

    def mean(cells: Sequence[Cell], what: str) -> float:
        return statistics.fmean(done[cell.name][what] for cell in cells)

    nash, deaf = ({what: mean(rivals[name], what) for what in ("l_e", "jitter")} for name in ("nash", DEAF))
    within = [weights for weights in sweep if mean(swept[weights], "jitter") <= nash["jitter"]]
    best = min(within, key=lambda weights: mean(swept[weights], "l_e"), default=None)
    free = min(sweep, key=lambda weights: mean(swept[weights], "l_e"))
    return {
        "row": row,
        "nash": nash,
        "no_messages": deaf,
        "limit": None if best is None else {what: mean(swept[best], what) for what in ("l_e", "jitter")},
        "weights": None if best is None else best._asdict(),
        "any_jitter": {what: mean(swept[free], what) for what in ("l_e", "jitter")},
    }


def main() -> int:
    """Print a line per row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=names_of(ROWS), default=["A", "D", "F", "I"], metavar="A,D")
    parser.add_argument("--seeds", type=seeds_of, default=range(1000, 1002), metavar="FROM:TO")
    parser.add_argument("--workers", type=int, default=cores())
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    began = perf_counter()
    ensure_compiled(lambda text: print(text, file=sys.stderr))
    rows = []
    for row in options.rows:
        found = limit_of(row, options.seeds, options.workers)
        rows.append(found)
        if not options.json:
            parts = [
                f"{what} {found[what]['l_e']:.3f} mm at {found[what]['jitter']:.2f} mm/s"
                for what in ("no_messages", "nash", "limit", "any_jitter")
                if found[what] is not None
            ]
            print(f"{row}: {', '.join(parts)}", flush=True)
    if options.json:
        seeds = [options.seeds.start, options.seeds.stop]
        about = {"commit": commit(), "code": code_version(), "seeds": seeds, "wall_s": perf_counter() - began}
        print(json.dumps({**about, "rows": rows}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
