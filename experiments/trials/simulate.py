"""Simulate one trial in this process: the same trial gives the same result wherever it runs."""

import hashlib

import numpy as np

from experiments.trials.measures import BYTES, measured, record
from experiments.trials.result import Signals, TrialResult
from experiments.trials.trial import GAP_EVERY, SERIES_INTERVAL, Trial
from network.codec import encode
from runtime.inprocess import Simulation
from runtime.precompile import ensure_compiled
from world.measures.ledger import KEPT


def simulate(trial: Trial) -> TrialResult:
    """Simulate and measure one trial. Raises ScenarioError."""
    ensure_compiled(_silent)
    wanted, scenario = trial.measurement, trial.load()
    simulation = Simulation(scenario)
    gaps, plan_bytes = [], 0
    while not simulation.finished:
        k = simulation.world.k
        simulation.step()
        if BYTES in wanted.measures:
            plan_bytes += sum(len(encode(plan)) for plan in simulation.plans)
        if wanted.gap and k % GAP_EVERY == 0:
            stamp = k * scenario.control_interval
            gaps.append([agent.status(k, stamp).gap for _, agent in sorted(simulation.agents.items())])
    trace = simulation.trace
    world = simulation.world
    ledger = tuple(world.ledger.newest(KEPT))
    seen = record(scenario, trace, world.counts, wanted.warmup, wanted.event, plan_bytes=plan_bytes, excursions=ledger)
    stride = max(1, round(SERIES_INTERVAL / scenario.control_interval))
    sampled = np.array(gaps, dtype=float).reshape(-1, scenario.size)
    return TrialResult(
        values=measured(wanted.measures, seen),
        trajectory_sha256=hashlib.sha256(trace.poses.astype("<f8").tobytes()).hexdigest(),
        series=seen.level[::stride] if wanted.series else np.zeros(0),
        signals=Signals.of(scenario, trace.poses, trace.inputs, sampled, ledger) if wanted.signals else None,
    )


def _silent(_: str) -> None:
    """Who asks has compiled already; a worker elsewhere has nobody to tell."""
