"""Short records for tests: of a run in one process, with all that happened in it."""

from collections.abc import Callable
from pathlib import Path

from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.values import Mode
from records.file import RecordFile
from records.recorder import Detail
from runtime.inprocess import Simulation
from runtime.recording import Recording
from world.world import World

STARTED = 1_700_000_000_000_000_000
LOSSY = ["duration=2.5", "link.loss=0.2", "link.latency=0.03", "faults=[{at=1, until=2, link='1->2', cut=true}]"]


def scenario(*settings: str, name: str = "triangle-circle") -> Scenario:
    return load(name, [*LOSSY, *settings])


def record(
    path: Path,
    what: Scenario,
    detail: Detail = "default",
    *,
    flush_every: int = 50,
    mode: Mode = "lockstep",
    before: Callable[[World], object] = lambda _: None,
) -> Simulation:
    """Simulate it, with a record in a new file that says it is of this mode; `before` each tick users may act."""
    simulation = Simulation(what)
    simulation.world.mode = mode
    with RecordFile(path) as file:
        recording = Recording(simulation, file, STARTED, detail)
        while not simulation.finished:
            before(simulation.world)
            recording.step()
            if simulation.world.k % flush_every == 0:
                file.flush()
    return simulation
