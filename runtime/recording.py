"""A record of an episode that is simulated in one process: the messages that a recorder's process gets."""

from collections.abc import Callable
from pathlib import Path
from time import monotonic, time_ns
from typing import Any

from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from network import topics
from network.codec import encode
from network.messages import Command, Plan, Tick
from records.file import RecordFile
from records.recorder import Detail, Recorder
from runtime.inprocess import PROGRESS_TICKS, Simulation, summary_of
from world.journal import Journal

RUN = "inprocess"
FLUSH_SECONDS = 0.9
"""Between two flushes of the file [s]."""


class Recording:
    """Feeds the recorder of a simulation, tick by tick."""

    def __init__(self, simulation: Simulation, file: RecordFile, started: int, detail: Detail) -> None:
        """At t = 0.

        Args:
            simulation: what is recorded.
            file: to write to.
            started: now [ns since the epoch].
            detail: what is recorded.
        """
        self._simulation, self._file = simulation, file
        self._recorder = Recorder(file, RUN, started, detail=detail)
        self._journal = Journal(simulation.world, wanted=True)
        self._take()

    def go_on(self) -> None:
        """The simulation has begun a segment."""
        self._journal.go_on()
        self._journal.wanted = True

    def step(self) -> None:
        """Simulate one tick."""
        simulation, recorder = self._simulation, self._recorder
        tick = simulation.world.tick()
        answers = simulation.step()
        self._journal.note(answers)
        self._take()
        if recorder.full:
            recorder.take_wire(*_sent(topics.tick(RUN), tick))
            for robot, answer in answers.items():
                recorder.take_wire(*_sent(topics.command(RUN, robot), answer.command))
                if answer.plan is not None:
                    recorder.take_wire(*_sent(topics.plan(RUN, robot), answer.plan))
        for robot, agent in simulation.agents.items():
            if recorder.wants_status(robot):
                recorder.take_status(agent.status(tick.seq, tick.stamp))

    def _take(self) -> None:
        stretch = self._journal.take()
        if stretch is not None:
            self._recorder.take(stretch)


def _sent(key: str, message: Tick | Command | Plan) -> tuple[str, bytes]:
    """Key below the run's name, and bytes, as the wire has them."""
    return key.split("/", 2)[2], encode(message)


def simulate(
    scenario: Scenario,
    path: Path,
    *,
    detail: Detail = "default",
    progress: Callable[[float], None] = lambda _: None,
    warmup: float = 0.0,
) -> dict[str, Any]:
    """As runtime.inprocess.simulate, with a record in a new file.

    Raises:
        EchelonError: the file exists, or cannot be written.
    """
    began = flushed = monotonic()
    simulation = Simulation(scenario)
    try:
        with RecordFile(path) as file:
            recording = Recording(simulation, file, time_ns(), detail)
            while not simulation.finished:
                recording.step()
                if simulation.world.k % PROGRESS_TICKS == 0:
                    progress(simulation.world.now)
                    if monotonic() - flushed >= FLUSH_SECONDS:
                        file.flush()
                        flushed = monotonic()
    except OSError as error:
        raise EchelonError(f"cannot write {path}: {error.strerror}") from None
    return summary_of(simulation, monotonic() - began, warmup)
