"""What `echelon.simulate` adds to the engine, and how long `import echelon` takes.

python -m benchmarks.api [--rounds 7] [--json]

Both engines of a round are timed one after the other in this process (processor time); the figure is the median of the
paired ratios. Bounds: 1.05, and 0.5 s for the import in a process of its own.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import echelon
from benchmarks.bodies_cells import commit
from runtime import inprocess
from runtime.precompile import ensure_compiled

BOUND, IMPORT_SECONDS = 1.05, 0.5
SETTINGS = {"duration": 20, "noise": {"slip": 0.2, "gyro": 0.2, "position": 0.001, "heading": 0.01}}


def seconds(action: Callable[[], object]) -> float:
    """Processor time of an action [s]."""
    began = time.process_time()
    action()
    return time.process_time() - began


def import_seconds() -> float:
    """Duration of a process that imports echelon, less one that imports nothing [s]."""
    times = []
    for text in ("import echelon", "pass"):
        began = time.perf_counter()
        subprocess.run([sys.executable, "-c", text], check=True)
        times.append(time.perf_counter() - began)
    return times[0] - times[1]


def main() -> int:
    """Measure, print a line per figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ensure_compiled(lambda text: print(text, file=sys.stderr))
    scenario = echelon.load("triangle-circle", SETTINGS)
    echelon.simulate(scenario)
    ratios = [
        seconds(lambda: echelon.simulate(scenario)) / seconds(lambda: inprocess.simulate(scenario))
        for _ in range(options.rounds)
    ]
    ratio, imported = statistics.median(ratios), statistics.median(import_seconds() for _ in range(options.rounds))
    if options.json:
        figures = {"ratio": ratio, "low": min(ratios), "high": max(ratios), "import_s": imported}
        print(json.dumps({"commit": commit(), "rounds": options.rounds, **figures}))
    else:
        print(f"echelon.simulate against the engine: {ratio:.3f} ({min(ratios):.3f} to {max(ratios):.3f})")
        print(f"import echelon: {imported:.3f} s")
    return 0 if ratio <= BOUND and imported <= IMPORT_SECONDS else 1


if __name__ == "__main__":
    sys.exit(main())
