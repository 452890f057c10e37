"""One simulation of `benchmarks.bodies`: a row, a network, a controller, a seed."""

import hashlib
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.bodies_rows import CONTROLLERS, NETWORKS, ROWS
from benchmarks.speed import Checkout
from experiments.trials.code_version import code_version
from formation.scenario.files import parse, read
from formation.scenario.overrides import merged
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation

SCENARIO = "triangle-circle"
PLAN_EVERY = 2
ROBOTS = 3


class RowWork:
    """What a pool asks of a simulation of a row."""

    __slots__ = ()
    row: str

    @property
    def name(self) -> str:
        """All that makes it differ from others."""
        raise NotImplementedError

    @property
    def key(self) -> str:
        """Of its result, by this code."""
        return hashlib.sha256(f"{self.name} {code_version()}".encode()).hexdigest()

    @property
    def cost(self) -> int:
        """In ticks."""
        return round(ROWS[self.row].duration * 100)


@dataclass(frozen=True, slots=True)
class Cell(RowWork):
    """One simulation: work for a pool."""

    row: str
    network: str
    controller: str
    seed: int

    @property
    def name(self) -> str:
        return f"{self.row}, {self.network}, {self.controller}, seed {self.seed}"

    def scenario(self) -> Scenario:
        """What is simulated."""
        return scenario_of(self.row, self.network, CONTROLLERS[self.controller], self.seed)

    def simulation(self) -> Simulation:
        """It, at its start."""
        return Simulation(self.scenario())

    def run(self) -> dict[str, Any]:
        """As `measured`."""
        return measured(self.row, self.simulation())


def scenario_of(row: str, network: str, contender: Mapping[str, Any], seed: int) -> Scenario:
    """What is simulated; the contender's keys come last."""
    raw = {key: value for key, value in read(SCENARIO).items() if key != "robots"}
    common = {"seed": seed, "controller": {"name": "nash", "plan_every": PLAN_EVERY}}
    whole = merged(common, ROWS[row].overrides(seed, ROBOTS))
    return parse(raw, merged(merged(whole, NETWORKS[network]), contender))


def measured(row: str, simulation: Simulation) -> dict[str, Any]:
    """Simulate to the end; RMS from the row's warm-up on.

    Returns:
        l_e and the distance of the centre from the path [mm], changes from tick to tick of the commanded v (jitter)
        [mm/s] and of the commanded omega (turn_jitter) [mrad/s].
    """
    scenario, trace = simulation.world.scenario, simulation.simulate()
    first = round(ROWS[row].warmup / scenario.control_interval)
    distance, _, centre = trace.errors()
    changes = np.diff(trace.inputs[first:], axis=0)
    return {
        "l_e": _rms(distance[first:]),
        "centre": _rms(centre[first:]),
        "jitter": _rms(changes[..., 0]),
        "turn_jitter": _rms(changes[..., 1]),
    }


def _rms(values: Any) -> float:
    """In thousandths."""
    return 1e3 * math.sqrt(float(np.mean(np.square(values))))


def paired_ratio(ours: Sequence[float], others: Sequence[float]) -> tuple[float, float]:
    """Ratio of the means of values of the same seeds, and its standard error, 0 for one seed."""
    ratio = statistics.fmean(ours) / statistics.fmean(others)
    rest = [a - ratio * b for a, b in zip(ours, others, strict=True)]
    spread = statistics.stdev(rest) / math.sqrt(len(rest)) if len(rest) > 1 else 0.0
    return ratio, spread / statistics.fmean(others)


def commit() -> str:
    """Of the sources, with a mark if they were edited since."""
    return Checkout.here().commit()
