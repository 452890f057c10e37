"""How fast it is: both engines on the same episode in turn, and the time per plan.

python benchmarks/speed.py [--rounds 3] [--json]
"""

import argparse
import json
import statistics
import subprocess
import sys
from typing import Any

EPISODE = ("triangle-circle", "--duration", "40", "--json")
ENGINES = ("inprocess", "processes")


def main() -> None:
    """Measure and print; figures of one call belong together, the machine may be slower tomorrow."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    summaries: dict[str, list[dict[str, Any]]] = {engine: [] for engine in ENGINES}
    for done in range(options.rounds):
        for engine in ENGINES:
            print(f"round {done + 1} of {options.rounds}: {engine} ...", file=sys.stderr, flush=True)
            command = [sys.executable, "-m", "cli.main", "run", *EPISODE, "--engine", engine]
            out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            summaries[engine].append(json.loads(out))
    figures = {engine: _figures(runs) for engine, runs in summaries.items()}
    figures["processes / inprocess"] = {"wall": figures["processes"]["wall_s"] / figures["inprocess"]["wall_s"]}
    if options.json:
        print(json.dumps(figures))
        return
    for engine in ENGINES:
        f = figures[engine]
        print(
            f"{engine:>10}: 40 simulated s in {f['wall_s']:.2f} s (x{f['times_real_time']:.1f} real time); "
            f"a plan takes {f['solve_median_us']:.0f} us (median), {f['solve_p99_us']:.0f} us (p99)"
        )
    print(f"processes / inprocess: {figures['processes / inprocess']['wall']:.1f} x the time")


def _figures(runs: list[dict[str, Any]]) -> dict[str, float]:
    """Medians over the rounds."""
    wall = statistics.median(run["wall_s"] for run in runs)
    return {
        "wall_s": wall,
        "times_real_time": runs[0]["duration"] / wall,
        "solve_median_us": 1e6 * statistics.median(run["solve_s"]["median"] for run in runs),
        "solve_p99_us": 1e6 * statistics.median(run["solve_s"]["p99"] for run in runs),
    }


if __name__ == "__main__":
    main()
