"""Many robots in one process: real-time factor, memory and error, by how many they are.

python -m benchmarks.many [--robots 16,64,256,1024] [--scenarios circle,sinusoid] [--seconds 4] [--json FILE]

Each line is a process of its own: a polygon that keeps its orientation, from its slots, with noise and late messages;
so many simulated seconds are measured, after the first.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.speed import HERE, NOISE, TICK, Checkout
from formation.scenario.files import load
from runtime.inprocess import Simulation
from runtime.precompile import ensure_compiled

SPACING = 0.1
"""Between neighbours [m]."""
WARM_TICKS = 100
"""Before what is measured."""


def measure(scenario: str, robots: int, seconds: float) -> dict[str, float | int | str]:
    """Figures of one size, in this process."""
    began = time.process_time()
    shape = (f"formation={{shape='polygon', robots={robots}, spacing={SPACING}, orientation='fixed'}}",)
    simulation = Simulation(load(scenario, [*NOISE, *shape, f"duration={seconds + WARM_TICKS * TICK}"]))
    made = time.process_time() - began
    for _ in range(WARM_TICKS):
        simulation.step()
    ticks, best, began = 0, float("inf"), time.process_time()
    since = began
    while not simulation.finished:
        simulation.step()
        ticks += 1
        if ticks % 50 == 0:
            now = time.process_time()
            best, since = min(best, (now - since) / 50), now
    each = (time.process_time() - began) / ticks
    error = 1e3 * np.abs(simulation.trace.errors()[0][WARM_TICKS:])
    return {
        "scenario": scenario,
        "robots": robots,
        "factor": TICK / each,
        "us_per_robot": 1e6 * each / robots,
        "us_per_robot_best": 1e6 * min(best, each) / robots,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "made_s": made,
        "error_rms_mm": float(np.sqrt((error**2).mean())),
        "error_max_mm": float(error.max()),
        "contacts": simulation.world.contacts.count,
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", default="16,64,256,1024", metavar="N,N,...")
    parser.add_argument("--scenarios", default="circle,sinusoid", metavar="NAME,...")
    parser.add_argument("--seconds", type=float, default=4.0, help="of simulated time (default: 4)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    wanted = [(name, int(n)) for name in options.scenarios.split(",") for n in options.robots.split(",")]
    if options.one:
        print(json.dumps(measure(*wanted[0], options.seconds)))
        return
    ensure_compiled(lambda line: print(line, file=sys.stderr))
    began, figures = time.perf_counter(), []
    for name, robots in wanted:
        words = ("--one", "--scenarios", name, "--robots", str(robots), "--seconds", str(options.seconds))
        command = [sys.executable, "-m", "benchmarks.many", *words]
        threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": str(HERE)}
        done = subprocess.run(command, stdout=subprocess.PIPE, check=True, cwd=HERE, env={**os.environ, **threads})
        figures.append(f := json.loads(done.stdout))
        print(
            f"{name:10} {robots:4d} robots: {f['factor']:6.2f} x real time on one core, {f['us_per_robot']:5.0f} us a "
            f"robot and tick (fastest {f['us_per_robot_best']:.0f}), {f['memory_mb']:5.0f} MB, begun in "
            f"{f['made_s']:.1f} s; error rms {f['error_rms_mm']:.2f} mm, largest {f['error_max_mm']:.2f} mm, "
            f"contacts {f['contacts']}",
            flush=True,
        )
    if options.json:
        facts = {
            "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            "commit": Checkout(HERE, HERE).commit(),
            "took_s": round(time.perf_counter() - began, 1),
            "load": os.getloadavg(),
            "settings": list(NOISE),
            "figures": figures,
        }
        options.json.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
