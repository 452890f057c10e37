"""A run's processes without their work: messages of the same sizes, in the same order, through the same router.

They bound what lockstep can reach on a machine (benchmarks/ceiling.py). Python handles bytes only: nothing is decoded,
checked, solved or encoded. Where work is given, each process is busy for so long at each tick, which bounds what a run
can reach that loses nothing else. python -m benchmarks.bare ROLE ... is one of the processes.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import NamedTuple

import psutil

from benchmarks.speed import HERE
from formation.pattern import upstream
from network import topics
from network.bus import Sample
from network.zenoh_bus import Router, ZenohBus
from runtime.fork_server import ENVIRONMENT

RUN = "bare"
STATE_EVERY = 0.05
"""Between two states of the world [s]."""
STATUS_EVERY = 10
"""Ticks between two statuses of an agent; agents send ten a second."""
PATIENCE = 1.0
"""A tick that is not answered for this long is sent again [s]: the first may go out before everybody is subscribed."""
Process = subprocess.Popen[str]


class Work(NamedTuple):
    """Processor time of a tick [s]."""

    agent: float = 0.0
    world: float = 0.0


NO_WORK = Work()


class BareBus(ZenohBus):
    """The product's connection, for payloads as they are."""

    def send(self, key: str, payload: bytes) -> None:
        """Publish bytes on an announced key."""
        self._publishers[key].put(payload)


def bare_router(endpoint: str) -> None:
    """A router until its input ends."""
    router = Router([endpoint])
    print("ready", flush=True)
    sys.stdin.read()
    router.close()


def bare_agent(endpoint: str, robot: int, robots: int, sizes: dict[str, int], work: float) -> None:
    """Answer each tick once its neighbour's plan of the tick before is there, as agents do, and it has worked [s]."""
    with BareBus(endpoint, RUN) as bus:
        own, heard = topics.plan(RUN, robot), topics.plan(RUN, upstream(robot, robots))
        command, status = topics.command(RUN, robot), topics.status(RUN, robot)
        tick = topics.tick(RUN)
        for key in (own, command, status):
            bus.announce(key, reliable=True)
        bus.subscribe(tick)
        bus.subscribe(heard)

        def answer(number: int) -> None:
            for key, name in ((own, "Plan"), (command, "Command")):
                bus.send(key, _numbered(number, sizes[name]))

        newest = heard_of = answered = 0
        print("ready", flush=True)
        while True:
            for item in bus.arrivals(PATIENCE):
                if isinstance(item, Sample) and item.key == tick:
                    if (newest := max(newest, _number(item.payload))) == answered:
                        answer(answered)
                elif isinstance(item, Sample) and item.key == heard:
                    heard_of = max(heard_of, _number(item.payload))
            if answered < newest and heard_of >= answered:
                answered = newest
                _be_busy(work)
                answer(answered)
                if answered % STATUS_EVERY == 0:
                    bus.send(status, bytes(sizes["Status"]))


def _be_busy(seconds: float) -> None:
    """Use so much processor time."""
    until = time.thread_time() + seconds
    while seconds and time.thread_time() < until:
        pass


def _numbered(number: int, size: int) -> bytes:
    return number.to_bytes(8).ljust(size, b"\1")


def _number(payload: bytes) -> int:
    return int.from_bytes(payload[:8])


def bare_world(endpoint: str, robots: int, seconds: float, interval: float, sizes: dict[str, int], work: float) -> None:
    """Send ticks, and print how many a second, and which share of the commands was missing at the next one.

    Each tick goes out once all have answered the last one, or with an interval [s] when its time has come, after the
    world has worked [s].
    """
    with BareBus(endpoint, RUN) as bus:
        tick, state = topics.tick(RUN), topics.state(RUN)
        bus.announce(tick, reliable=True)
        bus.announce(state)
        bus.subscribe(topics.command(RUN, "*"))
        bus.subscribe(topics.status(RUN, "*"))
        print("ready", flush=True)
        sys.stdin.readline()
        commands = {topics.command(RUN, robot) for robot in range(1, robots + 1)}
        done, shown, missing, began = 0, 0.0, 0, time.perf_counter()
        while (now := time.perf_counter()) < began + seconds:
            left, due = set(commands), began + (done + 1) * interval
            _be_busy(work)
            while left:
                bus.send(tick, _numbered(done + 1, sizes["Tick"]))
                until = due if interval else time.perf_counter() + PATIENCE
                while (wait := until - time.perf_counter()) > 0.0 and (left or interval):
                    heard = (item for item in bus.arrivals(wait) if isinstance(item, Sample))
                    left -= {item.key for item in heard if _number(item.payload) == done + 1}
                if interval:
                    break
            missing += len(left)
            done += 1
            if now - shown > STATE_EVERY:
                bus.send(state, bytes(sizes["State"]))
                shown = now
        print(json.dumps((done / (time.perf_counter() - began), missing / (done * robots))), flush=True)
        sys.stdin.readline()  # its processor time is read meanwhile; then it is killed


@contextmanager
def _started(*words: str) -> Iterator[Process]:
    environment = {**os.environ, **ENVIRONMENT, "PYTHONPATH": str(HERE)}
    command = [sys.executable, "-m", "benchmarks.bare", *words]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment, cwd=HERE
    ) as process:
        try:
            _read(process)
            yield process
        finally:
            process.kill()


def _read(process: Process) -> str:
    assert process.stdout is not None
    if not (line := process.stdout.readline()):
        raise SystemExit("a bare process ended early")
    return line


def _tell(process: Process) -> None:
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()


class Bare(NamedTuple):
    """Figures of a run without work."""

    rate: float
    """[ticks/s]."""
    us: float
    """Processor time of all processes per tick [us]."""
    missed: float
    """Share of the commands that were not there at the next tick."""
    agent: float
    """Processor time of an agent, as a share of a core."""


def measure(robots: int, seconds: float, sizes: dict[str, int], interval: float = 0.0, work: Work = NO_WORK) -> Bare:
    """A run of so long; sizes of the messages by type [bytes]; with an interval between ticks [s], or in lockstep."""
    told = json.dumps(sizes)
    with tempfile.TemporaryDirectory(prefix="ech") as folder, ExitStack() as stack:
        endpoint = f"unixsock-stream/{folder}/r"
        router = stack.enter_context(_started("router", endpoint))
        world = stack.enter_context(
            _started("world", endpoint, str(robots), str(seconds), str(interval), told, str(work.world))
        )
        agents = [
            stack.enter_context(_started("agent", endpoint, str(robot), str(robots), told, str(work.agent)))
            for robot in range(1, robots + 1)
        ]
        everybody = [router, world, *agents]
        before, own = _processor(everybody), _processor(agents)
        _tell(world)
        rate, missed = json.loads(_read(world))
        spent = _processor(everybody) - before
        return Bare(rate, 1e6 * spent / (rate * seconds), missed, (_processor(agents) - own) / (seconds * robots))


def _processor(processes: list[Process]) -> float:
    """What they have used so far [s]."""
    return sum(sum(psutil.Process(process.pid).cpu_times()[:2]) for process in processes)


def main(role: str, endpoint: str, *words: str) -> None:
    """Be one of the processes."""
    if role == "router":
        bare_router(endpoint)
    elif role == "agent":
        bare_agent(endpoint, int(words[0]), int(words[1]), json.loads(words[2]), float(words[3]))
    else:
        bare_world(endpoint, int(words[0]), float(words[1]), float(words[2]), json.loads(words[3]), float(words[4]))


if __name__ == "__main__":
    main(*sys.argv[1:])
