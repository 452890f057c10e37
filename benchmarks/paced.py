"""What many robots cost here: in real time as processes, beside bare ones, and in one process as fast as it goes."""

import json
import os
import tempfile
from collections.abc import Callable, Iterator
from typing import Any

from benchmarks import bare
from benchmarks.realtime import real_time
from benchmarks.speed import NOISE, PROBE, REPEATS, SEEDS, TICK, Checkout

ALONE, TOGETHER = (8, 16, 24, 32), 64
"""Robots in real time with a process each, and with several robots a process."""
IN_PROCESS = {3: ("triangle-circle", 10.0), 8: ("ring-16", 5.0), 16: ("ring-16", 3.0), 64: ("ring-16", 1.0)}
"""Scenario and simulated time [s] by the number of robots."""


def paced_rows(seconds: float, sizes: dict[str, int], work: Callable[[int], bare.Work]) -> Iterator[dict[str, Any]]:
    """In real time at 100 Hz, each row measured for so long [s].

    Args:
        seconds: of each.
        sizes: of a bare run's messages [bytes].
        work: of a tick, by the number of robots.
    """
    for robots, busy in ((ALONE[-1], False), (ALONE[1], False), *((robots, True) for robots in ALONE)):
        found = bare.measure(robots, seconds, sizes, TICK, work(robots) if busy else bare.NO_WORK)
        how = "bare, busy for the steps of a tick" if busy else "bare"
        yield {"robots": robots, "how": how, "missed": found.missed, "cpu_agent": found.agent}
    for robots in (*ALONE, TOGETHER):
        more = () if robots == TOGETHER else ("--together", "1")
        with tempfile.TemporaryDirectory(prefix="ech") as folder:
            os.environ["ECHELON_RUNS"] = folder
            figures = real_time(robots, seconds, *more)
        kept = ("cpu_agent", "cpu_world", "cpu_router", "private_mb")
        how = "several a process" if robots == TOGETHER else "a process each"
        yield {"robots": robots, "how": how, "missed": figures["missed_share"], **{key: figures[key] for key in kept}}


def in_process_rows(checkout: Checkout) -> Iterator[dict[str, Any]]:
    """Ticks a second in one process: a plan every tick, estimator on, late and lost messages, the fastest episode."""
    for robots, (scenario, duration) in IN_PROCESS.items():
        size = () if robots in (3, 16) else (f"formation.robots={robots}",)
        wanted = (f"seed={SEEDS[0]}", f"duration={duration:g}", *NOISE, *size)
        text, _ = checkout.python("-c", PROBE, scenario, str(REPEATS), *wanted)
        yield {"robots": robots, "ticks_per_s": round(duration / TICK) / json.loads(text)[0]}


def shown(row: dict[str, Any]) -> str:
    """A row in words."""
    if "ticks_per_s" in row:
        rate = row["ticks_per_s"]
        return f"{row['robots']:3d} robots in process: {rate:6.0f} ticks/s, {rate * TICK:.1f} x real time on one core"
    text = f"{row['robots']:3d} robots in real time, {row['how']}: missed {row['missed']:.2%}"
    text += f", CPU of an agent {row['cpu_agent']:.1%}"
    if "cpu_world" in row:
        text += f", world {row['cpu_world']:.0%}, router {row['cpu_router']:.0%}, private {row['private_mb']:.0f} MB"
    return text
