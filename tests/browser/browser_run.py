"""A real run for the browser tests: router, world, agents and dashboard as processes of their own, and no launcher."""

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import IO, Self

from formation.scenario.overrides import from_settings, to_json
from network.access.robot_numbers import spelled
from network.control import Operation
from network.messages import Ghost, State
from tests.browser.watch import Watch

ROOT = Path(__file__).parents[2]
RUN = "browser"


class BrowserRun:
    """A run of a scenario; every process ends with it."""

    def __init__(
        self,
        scenario: str = "triangle-circle",
        robots: int = 3,
        agents: int | None = None,
        *,
        world: str = "world",
        settings: Sequence[str] = (),
        alone: Collection[int] | None = None,
    ) -> None:
        """Start everything.

        Args:
            scenario: its name.
            robots: of the scenario.
            agents: how many of them get an agent, if not all.
            world: its module.
            settings: key=value of the scenario.
            alone: whose agent has a process of its own, which a test can kill; the others share one. None: all.
        """
        self._folder = tempfile.TemporaryDirectory(prefix="echelon-")
        self.endpoint = f"unixsock-stream/{self._folder.name}/router"
        self._watch = Watch(self.endpoint, RUN)
        self._processes: dict[str, subprocess.Popen[str]] = {}
        try:
            self.start("router", "network", "--listen", self.endpoint)
            self._wait_for(Path(self._folder.name, "router"))
            changes = ["--overrides", to_json(from_settings(settings))]
            self.start("world", world, *self._run, "--scenario", scenario, "--endless", *changes)
            here = range(1, (robots if agents is None else agents) + 1)
            together = [] if alone is None else [robot for robot in here if robot not in alone]
            for robot in here:
                if robot not in together:
                    self.start_agent(robot)
            if together:
                self.start("agents", "agents", *self._run, "--together", "--ids", spelled(together))
            self.start("ghost", "runtime.ghost", *self._run)
            self.url = self.start_dashboard()
        except BaseException:
            self.close()
            raise

    def _wait_for(self, socket: Path, seconds: float = 60.0) -> None:
        """A busy machine may take longer to start a router than a client waits for one."""
        end = time.monotonic() + seconds
        while not socket.exists():
            assert time.monotonic() < end, "the router does not listen"
            time.sleep(0.05)

    @property
    def _run(self) -> list[str]:
        return ["--run", RUN, "--connect", self.endpoint]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self, name: str, module: str, *arguments: str, read: bool = False) -> subprocess.Popen[str]:
        """Start a process of the run."""
        log: IO[str] | None = sys.stderr if os.environ.get("ECHELON_TEST_VERBOSE") else None
        process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            cwd=ROOT,
            text=True,
            stdout=subprocess.PIPE if read else subprocess.DEVNULL,
            stderr=log or subprocess.DEVNULL,
        )
        self._processes[name] = process
        return process

    def start_agent(self, robot: int) -> None:
        """Start the agent of a robot."""
        self.start(f"agent-{robot}", "agents", *self._run, "--id", str(robot))

    def start_dashboard(self, port: int = 0) -> str:
        """Start the dashboard and return its address once it serves."""
        process = self.start("dashboard", "dashboard", *self._run, "--port", str(port), read=True)
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.fullmatch(r"dashboard: (http://127\.0\.0\.1:\d+)\n", line)
        assert found, f"expected the dashboard's address; got {line!r}"
        return found[1]

    def state(self, seconds: float = 10.0) -> State:
        """The next state."""
        return self._watch.state(seconds)

    def ghost(self) -> Ghost:
        """The next message of the ghost."""
        return self._watch.ghost()

    def ask(self, operation: Operation) -> None:
        """Request an operation of the world, as another page would."""
        self._watch.ask(operation)

    def pid(self, name: str) -> int:
        """Process id."""
        return self._processes[name].pid

    def end(self, name: str, *, kill: bool = False) -> None:
        """Terminate one process, or kill it."""
        process = self._processes.pop(name)
        if kill:
            process.kill()
        else:
            process.terminate()
        try:
            process.wait(5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()

    def close(self) -> None:
        """End everything; the router last, so that the others can close their sessions."""
        self._watch.close()
        for name in reversed(list(self._processes)):
            self.end(name)
        self._folder.cleanup()
