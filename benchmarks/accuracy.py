"""How exact it is: the figures of docs/figures.md, each beside the bound it is held to.

python benchmarks/accuracy.py [--seeds 20] [--json]
"""

import argparse
import json
import statistics
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from formation.scenario.files import load
from runtime.inprocess import simulate
from runtime.precompile import ensure_compiled

LATE = "link.latency=0.5"
NOISE = "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}"
NASH = [
    ("triangle-circle", 20.0, (), 0.05),
    ("circle", 20.0, (), 0.05),
    ("sinusoid", 20.0, (), 0.05),
    ("figure8", 20.0, (), 0.3),
    ("hexagon-sinusoid", 20.0, (), 0.1),
    ("spiral", 0.0, (), 0.6),
    ("triangle-corner", 30.0, (), 0.05),
    ("ring-16", 30.0, (), 0.2),
    ("triangle-circle", 20.0, (LATE,), 0.05),
]
"""Scenario, warm-up [s], settings, bound of the worst robot's RMS l_e [mm]."""
BASELINES = {
    "paper": {"figure8": 8.9, "circle": 8.0, "sinusoid": 5.2, "spiral": 12.0},
    "leader_follower": {"figure8": 50.0, "circle": 46.0, "sinusoid": 8.3, "spiral": 55.0},
}
"""RMS l_e of an independent prototype [mm], by controller and two-robot path."""

Job = tuple[str, tuple[str, ...], float]


def main() -> None:
    """Simulate everything and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ensure_compiled(print)
    jobs: list[Job] = [(name, settings, warmup) for name, warmup, settings, _ in NASH]
    jobs += [(path, (f"controller.name={name}",), 0.0) for name, paths in BASELINES.items() for path in paths]
    noisy = [
        ("triangle-circle", (NOISE, "duration=40", f"seed={seed}", *late), 20.0)
        for late in ((), (LATE,))
        for seed in range(options.seeds)
    ]
    with ProcessPoolExecutor() as pool:
        results = list(_counted(pool.map(_rms, [*jobs, *noisy]), len(jobs) + len(noisy)))
    found = dict(zip([*jobs, *noisy], results, strict=True))
    rows = [
        {"case": " ".join(["nash", name, *settings]), "mm": found[name, settings, warmup], "bound": bound}
        for name, warmup, settings, bound in NASH
    ]
    for controller, paths in BASELINES.items():
        for path, prototype in paths.items():
            rms = found[path, (f"controller.name={controller}",), 0.0]
            rows.append({"case": f"{controller} {path}", "mm": rms, "prototype": prototype, "ratio": rms / prototype})
    half = options.seeds
    ratios = [late / now for now, late in zip(results[-2 * half : -half], results[-half:], strict=True)]
    noise = {
        "case": f"nash with noise, 0.5 s late / on time, {half} seeds",
        "ratio_mean": statistics.fmean(ratios),
        "ratio_deviation": statistics.stdev(ratios),
        "on_time_mm": statistics.fmean(results[-2 * half : -half]),
        "late_mm": statistics.fmean(results[-half:]),
    }
    if options.json:
        print(json.dumps({"rows": rows, "noise": noise}))
        return
    for row in rows:
        other = f"bound {row['bound']}" if "bound" in row else f"prototype {row['prototype']}, ratio {row['ratio']:.2f}"
        print(f"{row['case']:<45} RMS l_e {row['mm']:9.4f} mm   {other}")
    print(
        f"{noise['case']}: {noise['ratio_mean']:.4f} +- {noise['ratio_deviation']:.4f} "
        f"({noise['late_mm']:.3f} / {noise['on_time_mm']:.3f} mm); bound 1.05"
    )


def _rms(job: Job) -> float:
    """Worst robot's RMS l_e [mm]."""
    name, settings, warmup = job
    robots: dict[str, Any] = simulate(load(name, settings), warmup=warmup)["robots"]
    return 1e3 * max(float(figures["distance_error_m"]["rms"]) for figures in robots.values())


def _counted(results: Iterable[float], total: int) -> Iterable[float]:
    for done, result in enumerate(results, start=1):
        print(f"\rflight {done} of {total}", end="", file=sys.stderr, flush=True)
        yield result
    print(file=sys.stderr)


if __name__ == "__main__":
    main()
