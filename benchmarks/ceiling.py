"""How near a run comes to what its messages alone cost here, and where the time of a tick goes.

python -m benchmarks.ceiling [--robots 3,8,16] [--rounds 3] [--seconds 4] [--lockstep] [--json FILE]

Bare: the same processes without their work (benchmarks/bare.py). The steps of a tick are timed one by one on the
messages of a simulation; bare processes that are busy for as long at each tick show what a run could reach that lost
nothing else. Each round measures all three, by turns. Beside the steps stands the processor time that all processes
took: what is left of that is waking up, queues, Zenoh, and cold caches. Then, but for --lockstep, missed ticks,
processor time and memory in real time, and ticks a second in one process (benchmarks/paced.py): some eight minutes in
all. The clock decides, so the machine should have nothing else to do; the ratio of a round bears some load.
"""

import argparse
import ctypes
import json
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any
from unittest.mock import patch

import msgpack

from benchmarks import bare
from benchmarks.paced import in_process_rows, paced_rows, shown
from benchmarks.speed import SEEDS, TICK, Checkout
from formation.scenario.files import load
from network.codec import decode, encode, unseal
from network.messages import Message
from runtime.inprocess import Simulation
from runtime.precompile import ensure_compiled

GOAL = 0.7
"""The share of the bare rate that lockstep should reach."""
AGENT, WORLD = "solve and everything else of an agent", "move the bodies and measure"
SUBREAPER = 36
"""Of prctl: who is orphaned below this process becomes its child, and its processor time is counted."""
WARM_TICKS, PART_TICKS = 200, 300
"""Of the simulation that the messages and the times of the steps are taken from."""


@dataclass(frozen=True, slots=True)
class Figure:
    """Lockstep with so many robots."""

    robots: int
    bare: float
    """Median rate [ticks/s]."""
    busy: float
    """The same of bare processes that are busy for as long as the steps take."""
    real: float
    of_busy: float
    """Median over the rounds of real / busy."""
    ratio: float
    """Median over the rounds of real / bare."""
    low: float
    high: float
    bare_us: float
    """Processor time of all processes per tick, median [us]."""
    real_us: float
    steps_us: dict[str, float]
    """Processor time of the steps of a tick, of one message or agent each [us]."""


def measure_real(checkout: Checkout, robots: int, seconds: float, rate: float) -> tuple[float, float]:
    """Rate [ticks/s] and processor time of all processes per tick [us]: of a long run less a short one."""
    short, long = 2.0, 2.0 + max(4.0, seconds * rate * TICK)  # simulated [s]
    settings = (f"--set=formation.{s}" for s in ("shape=polygon", f"robots={robots}", "spacing=0.2"))
    options = ("--engine=processes", "--together=1", *settings)  # as the bare ones
    found = []
    for duration in (short, long):
        before = _children()
        summary = checkout.run("circle", 1, duration, *options)
        found.append((summary["wall_s"], _children() - before))
    ticks = round((long - short) / TICK)
    return ticks / (found[1][0] - found[0][0]), 1e6 * (found[1][1] - found[0][1]) / ticks


def _children() -> float:
    """Processor time of all processes that this one has started and that have ended [s]."""
    while True:
        try:
            os.wait()
        except ChildProcessError:
            spent = os.times()
            return spent.children_user + spent.children_system


def steps(robots: int) -> tuple[dict[str, int], dict[str, float]]:
    """Sizes of the messages of a tick [bytes], and what each step of it costs [us of processor time]."""
    formation = {"shape": "polygon", "robots": robots, "spacing": 0.2}
    simulation = Simulation(load("circle", {"formation": formation, "duration": 60.0}))
    for _ in range(WARM_TICKS):
        answers = simulation.step()
    world, agent = simulation.world, simulation.agents[1]
    answer, tick = answers[1], world.tick()
    assert answer.plan is not None
    status = agent.status(tick.seq - 1, tick.stamp)
    state = world.state(seq=1, status="running", speed=0.0, pace=1.0, overruns=0, rejected=0, waiting_for=[])
    messages: list[Message] = [tick, answer.plan, answer.command, status, state]
    sizes = {type(message).__name__: len(encode(message)) for message in messages}
    found: dict[str, float] = {}
    for message in messages:
        name, payload, kind = type(message).__name__, encode(message), type(message)
        found[f"encode {name}"] = _timed(partial(encode, message))
        found[f"unpack {name}"] = _timed(partial(_unpack, payload))
        found[f"check {name}"] = _timed(partial(decode, kind, payload)) - found[f"unpack {name}"]
    whole, found[WORLD] = _tick(simulation)
    found[AGENT] = (whole - found[WORLD]) / robots
    return sizes, found


def work_of(parts: dict[str, float], robots: int) -> bare.Work:
    """Processor time of a tick, by the steps that an agent and the world take at each."""
    agent = ("unpack Tick", "check Tick", "unpack Plan", "check Plan", AGENT, "encode Plan", "encode Command")
    answers = robots * (parts["unpack Command"] + parts["check Command"])
    return bare.Work(1e-6 * sum(parts[name] for name in agent), 1e-6 * (parts["encode Tick"] + answers + parts[WORLD]))


def _tick(simulation: Simulation) -> tuple[float, float]:
    """Processor time of a tick, and what of it is the world's [us]."""
    spent, world = 0.0, simulation.world

    def timed(call: Callable[..., Any]) -> Callable[..., Any]:
        def measured(*arguments: Any) -> Any:
            nonlocal spent
            began = time.process_time()
            found = call(*arguments)
            spent += time.process_time() - began
            return found

        return measured

    began = time.process_time()
    with patch.object(world, "tick", timed(world.tick)), patch.object(world, "advance", timed(world.advance)):
        for _ in range(PART_TICKS):
            simulation.step()
    return 1e6 * (time.process_time() - began) / PART_TICKS, 1e6 * spent / PART_TICKS


def _unpack(payload: bytes) -> object:
    return msgpack.unpackb(unseal(payload))


def _timed(call: Callable[[], object]) -> float:
    """The fastest of several rounds [us]."""
    best = 1.0
    for _ in range(20):
        began = time.process_time()
        for _ in range(50):
            call()
        best = min(best, (time.process_time() - began) / 50)
    return 1e6 * best


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", default="3,8,16", metavar="N,N,...")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=4.0, help="of each measurement (default: 4)")
    parser.add_argument("--lockstep", action="store_true", help="nothing but lockstep")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    options = parser.parse_args()
    ensure_compiled(lambda line: print(line, file=sys.stderr))
    ctypes.CDLL(None).prctl(SUBREAPER, 1, 0, 0, 0)
    checkout = Checkout.here()
    began, figures = time.perf_counter(), []
    for robots in map(int, options.robots.split(",")):
        print(f"{robots} robots ...", file=sys.stderr, flush=True)
        figures.append(_figure(checkout, robots, options.rounds, options.seconds))
        _show(figures[-1])
    rows = []
    for row in () if options.lockstep else chain(in_process_rows(checkout), _paced(options.seconds)):
        rows.append(row)
        print(shown(row), flush=True)
    if options.json:
        facts = {
            "date": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            "commit": checkout.commit(),
            "rounds": options.rounds,
            "seeds": SEEDS[:1],
            "seconds": options.seconds,
            "took_s": round(time.perf_counter() - began, 1),
            "load": os.getloadavg(),
            "lockstep": [asdict(figure) for figure in figures],
            "rows": rows,
        }
        options.json.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


def _paced(seconds: float) -> Iterator[dict[str, Any]]:
    sizes, parts = steps(16)
    yield from paced_rows(seconds, sizes, partial(work_of, parts))


def _figure(checkout: Checkout, robots: int, rounds: int, seconds: float) -> Figure:
    sizes, parts = steps(robots)
    bares, busies, reals, rate = list[bare.Bare](), list[bare.Bare](), list[tuple[float, float]](), 200.0
    measures: list[Callable[[], None]] = [
        lambda: bares.append(bare.measure(robots, seconds, sizes)),
        lambda: busies.append(bare.measure(robots, seconds, sizes, work=work_of(parts, robots))),
        lambda: reals.append(measure_real(checkout, robots, seconds, rate)),
    ]
    for done in range(rounds):
        for one in measures[:: 1 if done % 2 == 0 else -1]:
            one()
        rate = reals[-1][0]
    ratios = [real[0] / bound.rate for real, bound in zip(reals, bares, strict=True)]
    of_busy = statistics.median(real[0] / bound.rate for real, bound in zip(reals, busies, strict=True))
    busy = statistics.median(found.rate for found in busies)
    (bare_rate, bare_us), (real_rate, real_us) = (
        map(statistics.median, zip(*side, strict=True)) for side in ([found[:2] for found in bares], reals)
    )
    middle = statistics.median(ratios)
    spread = min(ratios), max(ratios)
    return Figure(robots, bare_rate, busy, real_rate, of_busy, middle, *spread, bare_us, real_us, parts)


def _show(f: Figure) -> None:
    print(
        f"{f.robots:3d} robots: lockstep {f.real:.0f} ticks/s, bare {f.bare:.0f}: {f.ratio:.0%} of it "
        f"({f.low:.0%} to {f.high:.0%}; goal {GOAL:.0%})\n"
        f"    busy for the steps below, bare ones reach {f.busy:.0f} ticks/s: {f.of_busy:.0%} of that\n"
        f"    processor time of a tick, all processes: {f.real_us:.0f} us, bare {f.bare_us:.0f} us; its steps:"
    )
    for name, cost in f.steps_us.items():
        print(f"      {name:42} {cost:8.1f} us")


if __name__ == "__main__":
    main()
