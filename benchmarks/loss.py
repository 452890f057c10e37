"""Two hosts with a lossy cable between them, in real time: ages of plans, and whether the formation lasts.

python -m benchmarks.loss [--transport quic|udp|tcp] [--loss 20] [--seconds 15] [--runs 1] [--json]

Wants root, iproute2 and nftables: hosts are network namespaces. Robot 1's agent, the world and the router are on one
host, the agents of robots 2 and 3 on the other, and of what that one sends so much is lost. `age` are the ages of the
plans that robots acted on, by link, beside those of the faulty link's model with the same loss.
"""

import argparse
import json
import re
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from benchmarks.two_hosts import Host, lose, two_hosts
from formation.arrays import FloatArray
from formation.errors import EchelonError
from formation.pattern import upstream
from formation.scenario.files import load
from network import topics
from network.access.keys import PORT
from network.access.robot_numbers import parsed
from network.bus import Sample
from network.codec import decode
from network.messages import Command, State, Status
from network.zenoh_bus import ZenohBus
from runtime.inprocess import Simulation

RUN, SCENARIO, SIZE = "loss", "triangle-circle", 3
LOSSY = ("2->3", "3->1")
"""Links from the host whose messages are lost."""
START_SECONDS = 40.0
SETTLE_SECONDS = 3.0
"""After the beginning of the loss nothing is measured for so long [s]."""
WHOLE, WHOLE_SECONDS = 0.01, 5.0
"""Largest distance error of a formation that is whole [m], and time for that after the loss has ended [s]."""
Found = TypeVar("Found")
_JOIN = re.compile(r"echelon join (.+)")


@dataclass(frozen=True, slots=True)
class Result:
    """Of one run."""

    transport: str
    age: dict[str, tuple[float, float, float]]
    """By link: p50, p90, longest [s]."""
    lost: dict[str, float]
    """By link, the share of plans that the agents count as lost."""
    worst: float
    """Largest distance error meanwhile [m]."""
    whole_after: float | None
    """Time from the end of the loss until the formation was whole [s]; None: it was not within WHOLE_SECONDS."""


def measure(transport: str, percent: int, seconds: float) -> Result:
    """One run."""
    with tempfile.TemporaryDirectory(prefix="ech") as folder, two_hosts(Path(folder)) as (here, there):
        logs = Path(folder) / "up", Path(folder) / "join"
        with logs[0].open("w") as up, logs[1].open("w") as joined:
            words: tuple[str, ...] = (
                "--run",
                RUN,
                "--no-dashboard",
                "--realtime",
                "--agents",
                "1",
                "--listen",
                here.address,
            )
            words += ("--transport", "tcp" if transport == "tcp" else "udp")
            here.start(up, "up", SCENARIO, *words, *(["--insecure"] if transport == "udp" else []))
            found = _until(lambda: _JOIN.search(logs[0].read_text()), logs[0])
            there.start(joined, "join", *found[1].split())
            _until(lambda: len(_here(logs[0].read_text())) == SIZE, logs[0])
            with ZenohBus(f"unixsock-stream/{here.runs}/{RUN}/router.sock", RUN) as bus:
                return _observe(bus, here, transport, percent, seconds)


def model(percent: int, duration: float = 40.0) -> dict[str, tuple[float, float, float]]:
    """Ages that the model of a faulty link gives, in one process."""
    faults = [{"link": link, "loss": percent / 100.0} for link in LOSSY]
    simulation = Simulation(load(SCENARIO, {"faults": faults, "duration": duration}))
    ages = simulation.simulate().rows(1)[:, 5 * SIZE : 6 * SIZE]
    return {link: _figures(ages[:, int(link[-1]) - 1]) for link in ("1->2", *LOSSY)}


def _observe(bus: ZenohBus, lossy: Host, transport: str, percent: int, seconds: float) -> Result:
    for key in (topics.command(RUN, "*"), topics.status(RUN, "*"), topics.state(RUN)):
        bus.subscribe(key)
    lose(lossy, PORT, percent)
    _watch(bus, SETTLE_SECONDS)
    begun, _, _ = _watch(bus, 0.5)
    after, ages, worst = _watch(bus, seconds)
    lossy.run("nft", "delete", "table", "inet", "loss")
    ended, whole = time.monotonic(), None
    while whole is None and time.monotonic() - ended < WHOLE_SECONDS:
        if _watch(bus, 0.2)[2] < WHOLE:
            whole = time.monotonic() - ended
    lost = {
        link: (after[link].counts.lost - first.counts.lost) / max(after[link].counts.sent - first.counts.sent, 1)
        for link, first in begun.items()
        if link in after
    }
    found = {link: _figures(np.array(ages[link])) for link in sorted(ages)}
    return Result(transport, found, lost, worst, whole)


def _watch(bus: ZenohBus, seconds: float) -> tuple[dict[str, Status], dict[str, list[float]], float]:
    """For so long [s]: the newest status by link, every age by link, the largest distance error."""
    statuses: dict[str, Status] = {}
    ages: dict[str, list[float]] = {}
    worst = 0.0
    for item in bus.incoming(seconds):
        if not isinstance(item, Sample):
            continue
        topic = topics.topic_of(item.key)
        if topic is topics.COMMAND:
            command = decode(Command, item.payload)
            ages.setdefault(f"{upstream(command.sender, SIZE)}->{command.sender}", []).append(command.age)
        elif topic is topics.STATUS:
            status = decode(Status, item.payload)
            statuses[str(status.link)] = status
        elif topic is topics.STATE:
            worst = max(worst, float(np.abs(decode(State, item.payload).distance_errors).max()))
    return statuses, ages, worst


def _figures(ages: FloatArray) -> tuple[float, float, float]:
    known = ages[~np.isnan(ages)]
    median, ninety = np.quantile(known, (0.5, 0.9)).tolist()
    return median, ninety, float(known.max())


def _here(told: str) -> frozenset[int]:
    """Robots whose agents have come, by what `up` told."""
    return frozenset[int]().union(*map(parsed, re.findall(r"agents? (\S+) (?:is|are) here", told)))


def _until(look: Callable[[], Found | None], log: Path) -> Found:
    until = time.monotonic() + START_SECONDS
    while time.monotonic() < until:
        found = look()
        if found:
            return found
        time.sleep(0.1)
    raise EchelonError(f"the run did not start: {log.read_text()}")


def main() -> int:
    """Print the figures of each run. Exit code 1 if a formation did not last."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--transport", choices=["quic", "udp", "tcp"], default="quic")
    parser.add_argument("--loss", type=int, default=20, metavar="PERCENT")
    parser.add_argument("--seconds", type=float, default=15.0, help="that are measured")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results = [measure(options.transport, options.loss, options.seconds) for _ in range(options.runs)]
    expected = model(options.loss)
    if options.json:
        print(json.dumps({"runs": [asdict(result) for result in results], "model": expected}))
    else:
        print("age p50 / p90 / max in ms")
        for link, figures in expected.items():
            print(f"model  {link}: {_text(figures)}")
        for result in results:
            for link, figures in result.age.items():
                print(f"{result.transport}    {link}: {_text(figures)}, lost {result.lost.get(link, 0.0):.1%}")
            after = "not whole" if result.whole_after is None else f"whole after {result.whole_after:.1f} s"
            print(f"       largest error {result.worst * 1e3:.1f} mm, {after}")
    return int(any(result.whole_after is None for result in results))


def _text(figures: tuple[float, float, float]) -> str:
    return " / ".join(f"{figure * 1e3:.0f}" for figure in figures)


if __name__ == "__main__":
    sys.exit(main())
