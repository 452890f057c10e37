"""How fast it is beside another checkout: both in turn, on one machine, in one go.

python benchmarks/speed.py --against PATH [--rounds 7] [--json FILE]

Each round runs every measurement in both checkouts, which begins by turns. Figures of one round are a pair: both
saw the same load, so their ratio says more than either. Processes are driven by the command line and measured by the
clock: that needs a machine with nothing else to do. One process is measured by the processor time of the fastest of
`REPEATS` episodes, which bears other load.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

HERE = Path(__file__).parents[1]
BOUND = 1.05
"""The time that this checkout may take for each measurement, as a share of the other's (median of the rounds)."""
SEEDS = (1, 2, 3)
"""Of the runs, by turns."""
NOISE = ("noise.slip=0.2", "noise.gyro=0.2", "link.latency=0.3", "link.loss=0.3")
"""So that no robot is at rest in its slot."""
TICK = 0.01
"""delta_t of the scenarios below [s]."""
REPEATS = 3
PROBE = """
import json, sys, time
try:
    from formation.scenario.files import load
    from runtime.inprocess import simulate
except ImportError:  # before the packages were named so
    from formation.scenario import load
    from fleet.inprocess import fly as simulate
scenario, seconds, solves = load(sys.argv[1], sys.argv[3:]), [], []
for _ in range(int(sys.argv[2])):
    began = time.process_time()
    summary = simulate(scenario)
    seconds.append(time.process_time() - began)
    solves.append(summary["solve_s"]["median"])
print(json.dumps([min(seconds), min(solves)]))
"""
"""Processor time of an episode and median time of its solves [s], in the names of either checkout."""
PARTS = """
import json, sys, time
try:
    from agents.controllers.best_response import BestResponse
    from agents.window_estimator import WindowEstimator
    from formation.scenario.files import load
    from runtime.inprocess import Simulation
except ImportError:  # before there was an estimator
    raise SystemExit(print("[NaN, NaN]"))

spent = {}


def timed(kind, name):
    call = getattr(kind, name)

    def measured(*arguments):
        began = time.perf_counter()
        found = call(*arguments)
        spent[kind] += time.perf_counter() - began
        return found

    setattr(kind, name, measured)


timed(BestResponse, "plan")
for name in ("roll", "sense", "hear", "estimate", "neighbour"):
    timed(WindowEstimator, name)
best = [1.0, 1.0]
simulation = Simulation(load(sys.argv[1], sys.argv[3:]))
for _ in range(100 * int(sys.argv[2])):
    spent.update({BestResponse: 0.0, WindowEstimator: 0.0})
    for _ in range(10):
        simulation.step()
    solve, estimate = (spent[kind] / (10 * len(simulation.agents)) for kind in (BestResponse, WindowEstimator))
    best = [min(best[0], solve), min(best[1], solve + estimate)]
print(json.dumps(best))
"""
"""Time of a robot's solve, and of its estimator and solve together, in a tick; the fastest ten in a row [s]."""
MEASUREMENTS: dict[str, Callable[["Checkout", int], dict[str, float]]] = {}
"""Time [s] of each figure, by name, of one checkout and seed."""


def own_cache() -> Path:
    """Where the kernels of this checkout are kept."""
    return Path(os.environ.get("ECHELON_CACHE") or Path.home() / ".cache")


@dataclass(frozen=True, slots=True)
class Checkout:
    """A folder with sources, and where its kernels are kept."""

    path: Path
    cache: Path

    @classmethod
    def here(cls) -> Self:
        """This one, with the kernels that everybody uses."""
        return cls(HERE, own_cache())

    def call(self, *arguments: str) -> tuple[str, float]:
        """Output and duration [s] of one command of the command line."""
        return self.python("-m", "cli.main", *arguments)

    def python(self, *arguments: str) -> tuple[str, float]:
        """Output and duration [s] of one Python process."""
        threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        environment = {**os.environ, "PYTHONPATH": str(self.path), "ECHELON_CACHE": str(self.cache), **threads}
        command = [sys.executable, *arguments]
        began = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=self.path)
        if done.returncode:
            raise SystemExit(f"{self.path}: {arguments}: {done.stderr.strip()}")
        return done.stdout, time.perf_counter() - began

    def run(self, scenario: str, seed: int, duration: float, *more: str) -> dict[str, Any]:
        """Summary of one run; `wall` is added, how long the command took as a whole [s]."""
        options = [f"--set={setting}" for setting in (f"seed={seed}", *NOISE)]
        text, wall = self.call("run", scenario, "--duration", f"{duration:g}", "--json", *options, *more)
        return {**json.loads(text), "wall": wall}

    def commit(self) -> str:
        """Of the sources; with a mark if they were edited since."""
        command = ["git", "-C", str(self.path), "describe", "--always", "--dirty", "--abbrev=12"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        return done.stdout.strip() or "no repository"


@dataclass(frozen=True, slots=True)
class Figure:
    """One measurement of both checkouts."""

    name: str
    ours: float
    """Median time [s]."""
    theirs: float
    ratio: float
    """Median over the rounds of ours / theirs; above `BOUND` this checkout is too slow."""
    low: float
    """The smallest and the largest ratio."""
    high: float

    @classmethod
    def of(cls, name: str, pairs: list[tuple[float, float]]) -> "Figure":
        """From (ours, theirs) of every round."""
        ratios = [ours / theirs for ours, theirs in pairs]
        medians = [statistics.median(side) for side in zip(*pairs, strict=True)]
        return cls(name, medians[0], medians[1], statistics.median(ratios), min(ratios), max(ratios))


def _in_process(scenario: str, duration: float, *settings: str) -> Callable[[Checkout, int], dict[str, float]]:
    def measure(checkout: Checkout, seed: int) -> dict[str, float]:
        wanted = (f"seed={seed}", f"duration={duration:g}", *NOISE, *settings)
        text, _ = checkout.python("-c", PROBE, scenario, str(REPEATS), *wanted)
        seconds, solve = json.loads(text)
        return {"tick": seconds / round(duration / TICK), "solve": solve}

    return measure


def _parts(scenario: str, *settings: str) -> Callable[[Checkout, int], dict[str, float]]:
    """With a robot that sees its neighbour in the window, measured every tick."""

    def measure(checkout: Checkout, seed: int) -> dict[str, float]:
        wanted = (f"seed={seed}", "duration=60", *NOISE[:2], *settings)
        text, _ = checkout.python("-c", PARTS, scenario, str(REPEATS), *wanted)
        solve, both = json.loads(text)
        return {"solve": solve, "estimator and solve": both}

    return measure


def _lockstep(scenario: str, short: float, long: float, *settings: str) -> Callable[[Checkout, int], dict[str, float]]:
    """The slope between a short and a long run: starting is not part of a tick."""

    def measure(checkout: Checkout, seed: int) -> dict[str, float]:
        more = ("--engine", "processes", *(f"--set={setting}" for setting in settings))
        one, other = (checkout.run(scenario, seed, t, *more) for t in (short, long))
        return {
            "tick": (other["wall_s"] - one["wall_s"]) / round((long - short) / TICK),
            "start": one["wall"] - one["wall_s"],
        }

    return measure


def _start(checkout: Checkout, seed: int) -> dict[str, float]:
    return {
        "run": checkout.run("circle", seed, 0.1, "--engine", "inprocess")["wall"],
        "help": checkout.call("--help")[1],
    }


MEASUREMENTS |= {
    "in process, 3 robots": _in_process("triangle-circle", 20.0),
    "in process, 8 robots": _in_process("ring-16", 10.0, "formation.robots=8"),
    "in process, 16 robots": _in_process("ring-16", 5.0),
    "in process, 64 robots": _in_process("ring-16", 1.0, "formation.robots=64"),
    "in process, no faults, 3 robots": _in_process("triangle-circle", 20.0, "link={}"),
    "parts, W = 2": _parts(
        "triangle-circle", "bodies.relative.sigma=0.002", "noise.position=0.001", "noise.heading=0.01"
    ),
    "lockstep, 3 robots": _lockstep("triangle-circle", 5.0, 25.0),
    "lockstep, 8 robots": _lockstep("ring-16", 2.0, 10.0, "formation.robots=8"),
    "lockstep, 16 robots": _lockstep("ring-16", 2.0, 7.0),
    "start": _start,
}


def measure(ours: Checkout, theirs: Checkout, rounds: int, only: str) -> list[Figure]:
    """Every measurement of both, `rounds` times in turn."""
    pairs: dict[str, list[tuple[float, float]]] = {}
    wanted = {name: call for name, call in MEASUREMENTS.items() if only in name}
    for checkout in (ours, theirs):
        checkout.run("circle", SEEDS[0], 0.1, "--engine", "inprocess")  # compiles the kernels
    for done in range(rounds):
        seed = SEEDS[done % len(SEEDS)]
        for name, call in wanted.items():
            print(f"round {done + 1} of {rounds}: {name}", file=sys.stderr, flush=True)
            order = (ours, theirs) if done % 2 == 0 else (theirs, ours)
            found = {checkout.path: call(checkout, seed) for checkout in order}
            for part, seconds in found[ours.path].items():
                pairs.setdefault(f"{name}: {part}", []).append((seconds, found[theirs.path][part]))
    return [Figure.of(name, both) for name, both in pairs.items()]


def main() -> None:
    """Measure and print; the exit status is 1 if anything is slower than `BOUND` allows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, required=True, metavar="PATH", help="the other checkout")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", default="", metavar="TEXT", help="measurements whose name holds this")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    options = parser.parse_args()
    base = own_cache() / "speed"
    ours, theirs = (
        Checkout(path.resolve(), base / side) for path, side in ((HERE, "ours"), (options.against, "theirs"))
    )
    began = time.perf_counter()
    figures = measure(ours, theirs, options.rounds, options.only)
    print(f"{'time of one':36} {'ours':>11} {'theirs':>11} {'ratio':>7}   smallest to largest")
    for f in figures:
        mark = "  SLOWER" if f.ratio > BOUND else ""
        print(f"{f.name:36} {_time(f.ours)} {_time(f.theirs)} {f.ratio:7.3f}   {f.low:.3f} to {f.high:.3f}{mark}")
    for f in figures:
        if f.name.endswith(": tick"):
            print(f"{f.name.removesuffix(': tick'):36} {1 / f.ours:9.0f}/s {1 / f.theirs:9.0f}/s ticks")
    if options.json:
        facts = {
            "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            "ours": ours.commit(),
            "theirs": theirs.commit(),
            "seeds": SEEDS[: options.rounds],
            "rounds": options.rounds,
            "took_s": round(time.perf_counter() - began, 1),
            "load": os.getloadavg(),
            "figures": [asdict(figure) for figure in figures],
        }
        options.json.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    raise SystemExit(any(f.ratio > BOUND or math.isnan(f.ratio) for f in figures))


def _time(seconds: float) -> str:
    return f"{1e6 * seconds:8.1f} us" if seconds < 1e-3 else f"{1e3 * seconds:8.1f} ms"


if __name__ == "__main__":
    main()
