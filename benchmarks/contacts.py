"""Contacts in seeded runs over all shipped scenarios, presets of bodies and networks, half of them with a stuck robot.

python -m benchmarks.contacts run FILE [--arms NAME ...] [--duration S] [--share I/N] [--seconds S]
python -m benchmarks.contacts show FILE ...

`run` adds a line of JSON per run to FILE and leaves out what is there already, so that it can be stopped at any time;
`show` prints the table. Arms: `nash` with the last filter and `without` it, `virtual_structure` and `leader_follower`
without it, and these two with it (`virtual_structure+`, `leader_follower+`).

A run is clean if nobody came to touch who did not touch at the start, the worst |l_e| of the last second is at most
WITHIN spacings, and the formation made PROGRESS of the path that belongs to the time in which no robot was stuck.
"""

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from formation.bodies.presets import PRESETS
from formation.errors import EchelonError
from formation.scenario.files import load, shipped
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation

SEED, RUNS = 17, 300
"""Of the drawing, and how many runs."""
DURATION = 24.0
"""How long a run is by default [s]."""
STUCK, FREE = 4.0, 14.0
"""In every second run a robot that is drawn does not move in this time [s]."""
WITHIN, PROGRESS = 0.25, 0.9
NEAR = 0.01
"""Places that are nearer than so many spacings are the same."""
ORDERS = [[0.0, 0.1, 0.2]]
"""Of the path that is driven: a circle."""
EVERY = 4
"""Ticks from plan to plan."""
LATE = {"latency": 0.3}
NETWORKS: dict[str, dict[str, Any]] = {
    "on time": {},
    "late": {"link": LATE},
    "bursty": {"link": {**LATE, "jitter": 0.05, "loss": 0.3, "burst": 4}},
    "cut": {"faults": [{"link": "1->2", "cut": True, "at": 6.0, "until": 12.0}]},
}
ARMS: dict[str, tuple[str, bool]] = {
    "nash": ("nash", True),
    "without": ("nash", False),
    "virtual_structure": ("virtual_structure", False),
    "leader_follower": ("leader_follower", False),
    "virtual_structure+": ("virtual_structure", True),
    "leader_follower+": ("leader_follower", True),
}
"""By name: the controller, and whether it has the last filter."""


class Case(NamedTuple):
    """What is drawn of a run."""

    number: int
    scenario: str
    preset: str
    network: str
    stuck: bool


def cases() -> list[Case]:
    """All runs. Every scenario meets every preset, every scenario and every preset every network."""
    draw = np.random.Generator(np.random.Philox(key=[SEED, 0]))
    pairs = [(scenario, preset) for scenario in shipped() for preset in PRESETS]
    networks, found = list(NETWORKS), []
    for lap in range(-(-RUNS // len(pairs))):
        for at in draw.permutation(len(pairs)):
            shift = int(at) // len(PRESETS) + int(at) % len(PRESETS) + lap
            stuck = bool((shift // len(networks) + lap) % 2)
            found.append((*pairs[at], networks[shift % len(networks)], stuck))
    return [Case(number, *case) for number, case in enumerate(found[:RUNS])]


def scenario_of(case: Case, arm: str, duration: float = DURATION) -> Scenario:
    """The scenario of a run; its seed is the run's number."""
    controller, avoid = ARMS[arm]
    raw: dict[str, Any] = {
        **NETWORKS[case.network],
        "bodies": {"preset": case.preset},
        "duration": duration,
        "seed": case.number,
        "robots": {"avoid": avoid},
        "controller": {"name": controller, "plan_every": EVERY},
    }
    if case.scenario == "drive-me":
        raw["path"] = {"commands": ORDERS}
    if case.stuck:
        size = load(case.scenario).size
        robot = 1 + int(np.random.Generator(np.random.Philox(key=[SEED, 1 + case.number])).integers(size))
        raw["disturbances"] = [{"robot": robot, "at": STUCK, "until": FREE, "drive": 0.0}]
    return load(case.scenario, raw)


def trial(case: Case, arm: str, duration: float = DURATION) -> dict[str, Any]:
    """Simulate one run."""
    row = {"arm": arm, **case._asdict(), "duration_s": duration}
    try:
        scenario = scenario_of(case, arm, duration)
    except EchelonError as refusal:
        return {**row, "refused": str(refusal).splitlines()[0]}
    began = perf_counter()
    simulation = Simulation(scenario)
    touched = simulation.world.contacts.count
    trace = simulation.simulate()
    error, _, _ = trace.errors()
    second = round(1.0 / scenario.control_interval)
    kept_off = simulation.world.at_limits
    return {
        **row,
        "scaled": scenario.bodies.scaled,
        "contacts": simulation.world.contacts.count - touched,
        "touched_at_start": touched,
        "gap_m": simulation.world.contacts.gap,
        "end_error": float(np.abs(error[-second:]).max()) / scenario.spacing,
        "progress": made(scenario, trace.poses) / (duration - (FREE - STUCK) * case.stuck),
        "kept_off_s": [kept_off.summary(robot)["kept_off_s"] for robot in range(1, scenario.size + 1)],
        "wall_s": perf_counter() - began,
    }


def made(scenario: Scenario, poses: Any) -> float:
    """The (last) time at which the reference's centre is where the formation's is at the end [s]."""
    times = np.arange(0.0, scenario.duration + 0.05, 0.05)
    way = scenario.reference().centre(times)
    gap = np.linalg.norm(way[:, :2] - poses[-1, :, :2].mean(axis=0), axis=1)
    return float(times[np.flatnonzero(gap <= gap.min() + NEAR * scenario.spacing)[-1]])


def clean(row: dict[str, Any]) -> bool:
    """Whether a run counts as one without a contact."""
    return bool(row["contacts"] == 0 and row["end_error"] <= WITHIN and row["progress"] >= PROGRESS)


def read(files: Iterable[Path]) -> list[dict[str, Any]]:
    """The runs in files, oldest first."""
    lines = [line for file in files if file.exists() for line in file.read_text(encoding="utf-8").splitlines()]
    return [json.loads(line) for line in lines]


def run(file: Path, arms: list[str], duration: float, share: str, seconds: float) -> None:
    """Simulate what is not in the file yet."""
    part, parts = (int(each) for each in share.split("/"))
    commit = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    done = {(row["arm"], row["number"]) for row in read([file])}
    began = perf_counter()
    for case in cases():
        for arm in arms:
            if case.number % parts != part or (arm, case.number) in done or perf_counter() - began > seconds:
                continue
            row = {**trial(case, arm, duration), "commit": commit}
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(row) + "\n")


def show(rows: list[dict[str, Any]]) -> None:
    """Print what came out."""
    for arm in ARMS:
        own = [row for row in rows if row["arm"] == arm]
        ran = [row for row in own if "refused" not in row]
        if not ran:
            continue
        for stuck in (False, True):
            some = [row for row in ran if row["stuck"] == stuck]
            touching = [row for row in some if row["contacts"]]
            print(
                f"{arm:19s} {'stuck' if stuck else 'free ':5s} runs {len(some):3d}  with contacts {len(touching):3d}  "
                f"contacts {sum(row['contacts'] for row in some):4d}  clean {sum(map(clean, some)):3d}  end out of "
                f"bounds {sum(row['end_error'] > WITHIN for row in some):3d}  progress short "
                f"{sum(row['progress'] < PROGRESS for row in some):3d}  of {len(own) - len(ran)} refused"
            )
    own = [row for row in rows if row["arm"] == "nash" and "refused" not in row]
    print("nash, runs that are not clean:")
    for row in own:
        if not clean(row):
            print(
                f"  {row['number']:3d} {row['scenario']}, {row['preset']}, {row['network']}"
                f"{', stuck' if row['stuck'] else ''}: contacts {row['contacts']}, gap {1000 * row['gap_m']:.1f} mm, "
                f"end {row['end_error']:.2f} spacings, progress {row['progress']:.2f}"
            )
    for text, found in (
        ("refused", Counter(f"{row['scenario']}, {row['arm']}" for row in rows if "refused" in row)),
        ("rescaled", Counter(f"{row['preset']} x {row['scaled']:.1f}" for row in own if row["scaled"] != 1.0)),
        ("pairs that touched at the start", Counter(row["scenario"] for row in own if row["touched_at_start"])),
    ):
        print(f"{text}: {dict(found)}")


def main() -> int:
    """Run or show; the exit code says whether every run of `nash` is clean."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["run", "show"])
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--arms", nargs="+", choices=list(ARMS), default=list(ARMS)[:4])
    parser.add_argument("--duration", type=float, default=DURATION, metavar="S", help="of a run; one for a file")
    parser.add_argument("--share", default="0/1")
    parser.add_argument("--seconds", type=float, default=float("inf"))
    options = parser.parse_args()
    if options.what == "run":
        run(options.files[0], options.arms, options.duration, options.share, options.seconds)
        return 0
    rows = read(options.files)
    show(rows)
    return 0 if all(clean(row) for row in rows if row["arm"] == "nash" and "refused" not in row) else 1


if __name__ == "__main__":
    sys.exit(main())
