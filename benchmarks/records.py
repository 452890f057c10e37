"""Size of a record, and what recording costs, for 3 and 16 robots: `python -m benchmarks.records`.

Prints JSON: MB per simulated minute with a chunk closed as often as in a live run, and the recorder's share of a core
in real time, of recording what a run sends; each for both details.
"""

import json
import sys
import tempfile
from pathlib import Path
from time import process_time, time_ns
from typing import Any, get_args

from formation.scenario.files import load
from network import topics
from network.bus import Sample
from network.codec import encode
from network.messages import Message
from network.throttled_log import ThrottledLog
from records.file import RecordFile
from records.process import FLUSH_SECONDS, take
from records.recorder import STATUS_SECONDS, Detail, Recorder
from runtime.inprocess import Simulation
from world.journal import Journal

SCENARIOS = {3: "triangle-circle", 16: "ring-16"}
SECONDS = 20.0
RUN = "benchmark"


def samples(scenario: str) -> list[list[Sample]]:
    """What a recorder of a run gets, by flush."""
    simulation = Simulation(load(scenario, [f"duration={SECONDS}"]))
    world = simulation.world
    interval, journal = world.scenario.control_interval, Journal(world, wanted=True)
    every, status_every = round(FLUSH_SECONDS / interval), round(0.2 * STATUS_SECONDS / interval)
    found: list[list[Sample]] = [[]]

    def send(key: str, message: Message | None) -> None:
        if message is not None:
            found[-1].append(Sample(key, encode(message)))

    while not simulation.finished:
        tick = world.tick()
        send(topics.tick(RUN), tick)
        answers = simulation.step()
        journal.note(answers)
        send(topics.stretch(RUN), journal.take())
        for robot, answer in answers.items():
            send(topics.plan(RUN, robot), answer.plan)
            send(topics.command(RUN, robot), answer.command)
            if tick.seq % status_every == 0:
                send(topics.status(RUN, robot), simulation.agents[robot].status(tick.seq, tick.stamp))
        if world.k % every == 0:
            found.append([])
    return found


def measure(batches: list[list[Sample]], detail: Detail) -> dict[str, float]:
    """Size and cost of recording them."""
    only_full = ("tick", "plan", "command")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.mcap"
        began = process_time()
        with RecordFile(path) as file:
            recorder, log = Recorder(file, RUN, time_ns(), detail=detail), ThrottledLog()
            for batch in batches:
                heard = (s for s in batch if detail == "full" or s.key.rsplit("/", 1)[-1] not in only_full)
                take(recorder, heard, log)
                file.flush()
        seconds = process_time() - began
        return {
            "mb_per_minute": path.stat().st_size / 1e6 * 60.0 / SECONDS,
            "percent_of_a_core": 100.0 * seconds / SECONDS,
        }


def main() -> None:
    """Print the figures."""
    found: dict[str, Any] = {}
    for robots, scenario in SCENARIOS.items():
        batches = samples(scenario)
        found[str(robots)] = {detail: measure(batches, detail) for detail in get_args(Detail)}
    json.dump(found, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
