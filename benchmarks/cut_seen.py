"""A cut link is seen: one robot knows the path, the link 1->2 is cut for some seconds, and the formation comes apart.

python -m benchmarks.cut_seen [--seeds N] [--first SEED] [--json FILE]

In process, scenario `follow-the-leader`. The noise of a seed is three times the 95th percentile of the worst |l_e| in
the SETTLED seconds before the cut; the control run of the same seed has no cut.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.metrics import clearance
from formation.scenario.files import load
from runtime.inprocess import Simulation

SCENARIO, LINK = "follow-the-leader", "1->2"
CUT, HEALED, SETTLED, END = 20.0, 26.0, 20.0, 40.0
"""When the link is cut, when it is whole again, what is looked at before, and where the episode ends [s]."""
PREVIEW, LEAVES, RETURNS = 2.0, 2.0, 10.0
"""Length of a preview; bounds: out of the noise so long after its end, in it again so long after healing [s]."""
SHARE, TIMES = 0.95, 3.0
APART, CONTACT = 0.020, 0.070
"""Least |l_e| as the link heals, and least distance of two centres [m]."""


def worst(seed: int, *, cut: bool) -> tuple[FloatArray, float]:
    """Worst |l_e| at every tick (T + 1,) and the least distance of two robots [m]."""
    fault = {"link": LINK, "cut": True, "at": CUT, "until": HEALED}
    scenario = load(SCENARIO, {"seed": seed, "duration": END, "faults": [fault] if cut else []})
    trace = Simulation(scenario).simulate()
    return np.abs(trace.errors()[0]).max(axis=1), clearance(trace.poses)


def trial(seed: int) -> dict[str, Any]:
    """The figures of one seed, and whether each is within its bound."""
    error, least = worst(seed, cut=True)
    control, _ = worst(seed, cut=False)
    t: FloatArray = np.arange(len(error)) * END / (len(error) - 1)
    noise = TIMES * float(np.quantile(error[(t >= CUT - SETTLED) & (t < CUT)], SHARE))
    above = t[(t >= CUT) & (error > noise)]
    left = float(above[0]) - CUT - PREVIEW if above.size else None
    back = float(above[-1]) - HEALED if above.size else None
    apart = float(error[np.searchsorted(t, HEALED)])
    return {
        "seed": seed,
        "noise_m": noise,
        "leaves_after_preview_s": left,
        "error_at_healing_m": apart,
        "whole_after_healing_s": back,
        "clearance_m": least,
        "control_max_m": float(control[t >= CUT].max()),
        "ok": {
            "leaves": left is not None and left <= LEAVES,
            "apart": apart > APART,
            "whole": back is not None and back <= RETURNS,
            "no_contact": least > CONTACT,
            "control": bool(control[t >= CUT].max() <= noise),
        },
    }


def main() -> int:
    """Print a line per seed; the exit code says whether all are within their bounds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    began, trials = perf_counter(), []
    for seed in range(options.first, options.first + options.seeds):
        trials.append(trial(seed))
        print(json.dumps(trials[-1]), flush=True)
    commit = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    good = all(all(found["ok"].values()) for found in trials)
    if options.json:
        result = {"commit": commit, "wall_s": perf_counter() - began, "ok": good, "trials": trials}
        options.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print("within bounds" if good else "OUT OF BOUNDS")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
