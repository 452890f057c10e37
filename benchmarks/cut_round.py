"""Cuts of many lengths that begin all round the path: contacts, least gap, and how long until the formation is whole.

python -m benchmarks.cut_round [--case NAME ...] [--links 1->2 ...] [--lengths S ...] [--places N] [--seeds N]
                               [--first SEED] [--workers N] [--json FILE]

In process. Each seed is driven once without a cut; at each place a copy of it goes on with the link cut. "Whole" is as
in benchmarks/cut_seen.py: worst |l_e| below three times the 95th percentile of the run without a cut. A run that is not
whole LOOKED s after healing counts as LOOKED. A line per scenario, link and length; then the runs with a contact.
"""

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from api.copying import copied
from benchmarks.cut_seen import SHARE, TIMES
from benchmarks.speed import Checkout
from formation.metrics import clearance
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation

LOOKED = 14.0
"""How long a run is looked at after healing [s]."""
BEGIN, LAP = 8.0, 126.0
"""Cuts begin between these times [s]."""
SETTLED = 200
"""Ticks at the start that are not looked at for the noise."""
TURNS = [[1.0, 0.05, 0.0], [15.0, 0.05, 0.15], [45.0, 0.05, -0.15], [75.0, 0.06, 0.3], [95.0, 0.04, -0.4]]
"""Orders of the driven path: when, v and omega [s, m/s, rad/s]."""
TOLD = {"path": {"known_to": "leader"}, "bodies": {"preset": "camera"}}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "default": ("follow-the-leader", {}),
    "without avoid": ("follow-the-leader", {"robots": {"avoid": False}}),
    "drive-me": ("drive-me", {"path": {"commands": TURNS}}),
    "drive-me, avoid": ("drive-me", {"path": {"commands": TURNS}, "robots": {"avoid": True}}),
    "hexagon": ("hexagon-sinusoid", TOLD),
    "triangle": ("triangle-circle", TOLD),
    "ring-16": ("ring-16", TOLD),
}
"""By name: a shipped scenario, and what of it is another way."""


def scenario_of(case: str, seed: int) -> Scenario:
    """The scenario of a case, 126 s long."""
    name, more = CASES[case]
    return load(name, {**more, "seed": seed, "duration": LAP + 2.0 * LOOKED})


def copy_of(simulation: Simulation) -> Simulation:
    """Another that goes on from here, to the same bits."""
    other: Simulation = copied({"it": simulation}, {})["it"]
    return other


def go_on(simulation: Simulation, until: float) -> None:
    """Simulate until a time [s]."""
    while simulation.world.now < until - 1e-6:
        simulation.step()


def trials(seed: int, case: str, links: list[str], lengths: list[float], places: int) -> list[dict[str, Any]]:
    """A row per cut of this seed: every link, length and place."""
    whole, copies = Simulation(scenario_of(case, seed)), []
    for place in range(places):
        go_on(whole, BEGIN + (LAP - BEGIN) * place / places)
        copies.append(copy_of(whole))
    go_on(whole, LAP)
    noise = TIMES * float(np.quantile(np.abs(whole.trace.errors()[0]).max(axis=1)[SETTLED:], SHARE))
    return [
        {"case": case, "seed": seed, "link": link, "length": length, **trial(copy_of(one), link, length, noise)}
        for one in copies
        for link in links
        for length in lengths
    ]


def trial(simulation: Simulation, link: str, length: float, noise: float) -> dict[str, Any]:
    """Cut the link now for so long [s], and look at what comes of it; noise is the error of a whole formation [m]."""
    world = simulation.world
    mark, first, touched = world.now, world.k, world.contacts.count
    world.change_fault(link, {"cut": True}, mark + length)
    go_on(simulation, mark + length + LOOKED)
    trace = simulation.trace
    error = np.nanmax(np.abs(trace.measured(first).distance), axis=1)
    above = np.flatnonzero(error > noise)
    widest = 2.0 * float(max(world.scenario.bodies.radii(world.scenario.size)))
    return {
        "at": mark,
        "contacts": world.contacts.count - touched,
        "gap_mm": 1000.0 * (clearance(trace.poses[first:]) - widest),
        "whole_s": max(0.0, above[-1] * world.scenario.control_interval - length) if above.size else 0.0,
        "apart_mm": 1000.0 * float(error.max()),
    }


def main() -> int:
    """Print the tables; the exit code says whether nobody touched and short cuts were whole within 10 s."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", nargs="+", choices=CASES, default=["default"])
    parser.add_argument("--links", nargs="+", default=["1->2"])
    parser.add_argument("--lengths", nargs="+", type=float, default=[6.0, 8.0, 10.0, 11.0, 12.0, 14.0])
    parser.add_argument("--places", type=int, default=12)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    began, rows = perf_counter(), []
    seeds = range(options.first, options.first + options.seeds)
    with ProcessPoolExecutor(options.workers) as pool:
        for case in options.case:
            work = partial(trials, case=case, links=options.links, lengths=options.lengths, places=options.places)
            for found in pool.map(work, seeds):
                rows += found
    keys = sorted({(row["case"], row["link"], row["length"]) for row in rows})
    print("case link length runs touching contacts least_gap_mm whole_median whole_worst over_10s")
    for key in keys:
        some = [row for row in rows if (row["case"], row["link"], row["length"]) == key]
        whole = [row["whole_s"] for row in some]
        touching = sum(row["contacts"] > 0 for row in some)
        print(
            *key, len(some), touching, sum(row["contacts"] for row in some),
            f"{min(row['gap_mm'] for row in some):.1f}", f"{np.median(whole):.1f}", f"{max(whole):.1f}",
            sum(each > 10.0 for each in whole),
        )  # fmt: skip
    for row in rows:
        if row["contacts"]:
            print({key: round(value, 2) if isinstance(value, float) else value for key, value in row.items()})
    seconds = perf_counter() - began
    print(f"{seconds:.0f} s")
    if options.json:
        facts = {"commit": Checkout.here().commit(), "seeds": list(seeds), "wall_s": seconds, "rows": rows}
        options.json.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    return 0 if all(row["contacts"] == 0 and (row["length"] > 8.0 or row["whole_s"] <= 10.0) for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
