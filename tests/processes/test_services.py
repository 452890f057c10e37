"""The services of compose.yaml, each by its very command, from another folder; only where they meet differs."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from network import topics
from network.codec import decode
from network.messages import State
from network.zenoh_bus import ZenohBus
from runtime.compose import ROUTER_PORT, RUN, SAVED
from tests.processes.live import compiled, wait_for
from world.resume.saver import SECONDS

__all__ = ["compiled"]
ROOT = Path(__file__).parents[2]


class Services:
    """Every service as a process, with the environment that it has in its container."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        with socket.socket() as probe, socket.socket() as page:
            for one in (probe, page):
                one.bind(("127.0.0.1", 0))
            port, self._page = (one.getsockname()[1] for one in (probe, page))
        (folder / "saved").mkdir()
        self._here = {f"router:{ROUTER_PORT}": f"127.0.0.1:{port}", f"0.0.0.0:{ROUTER_PORT}": f"127.0.0.1:{port}"}
        self._here |= {"0.0.0.0": "127.0.0.1", "8090": str(self._page), SAVED: str(folder / "saved")}
        self._services: dict[str, Any] = yaml.safe_load((ROOT / "compose.yaml").read_text())["services"]
        self.log = (folder / "log").open("w+")
        self.running: dict[str, subprocess.Popen[str]] = {}

    def _own(self, word: str) -> str:
        for there, here in self._here.items():
            word = word.replace(there, here)
        return word

    def environment(self, name: str) -> dict[str, str]:
        own = {key: self._own(value) for key, value in self._services[name]["environment"].items()}
        return {**os.environ, "PYTHONPATH": str(ROOT), **own}

    def start(self, name: str) -> None:
        words = [self._own(word) for word in self._services[name]["command"]]
        assert words[0] == "python"
        self.running[name] = subprocess.Popen(
            [sys.executable, *words[1:]], cwd=self._folder, env=self.environment(name), text=True, stderr=self.log
        )

    def start_all(self) -> None:
        """The router first: without it the others would wait, each a little longer after every attempt."""
        self.start("router")
        wait_for(lambda: self.healthy("router"))
        for name in self._services:
            if name != "router":
                self.start(name)

    @property
    def endpoint(self) -> str:
        return self.environment("world")["ECHELON_CONNECT"]

    def execute(self, *words: str) -> str:
        """As `docker compose exec world echelon WORDS`."""
        command = [sys.executable, "-m", "cli.main", *words]
        own = self.environment("world")
        done = subprocess.run(command, cwd=self._folder, env=own, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def healthy(self, name: str) -> bool:
        words = [self._own(word) for word in self._services[name]["healthcheck"]["test"][2:]]
        return (
            subprocess.run(
                [sys.executable, *words], cwd=self._folder, env=self.environment(name), check=False
            ).returncode
            == 0
        )

    def text(self) -> str:
        self.log.flush()
        return (self._folder / "log").read_text()


@pytest.fixture
def services(tmp_path: Path) -> Iterator[Services]:
    found = Services(tmp_path)
    yield found
    for process in found.running.values():
        process.terminate()
    for process in found.running.values():
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(10)
    found.log.close()


def test_they_make_a_run_that_obeys_commands_and_outlives_its_world(services: Services) -> None:
    services.start_all()
    with ZenohBus(services.endpoint, RUN, insecure=True) as session:
        states = session.keep(topics.state(RUN), 1)
        newest: list[State] = []

        def shown() -> State | None:
            newest[:] = [decode(State, sample.payload) for sample in states.take()] or newest
            return newest[-1] if newest else None

        wait_for(lambda: (state := shown()) and state.stamp > 0.5, seconds=90.0)  # each process imports numba
        assert services.healthy("agent-2")
        services.execute("fault", "set", "--link", "2->3", "--loss", "30%")
        before = wait_for(lambda: (state := shown()) and state.faults and state)
        services.running["world"].send_signal(signal.SIGKILL)
        services.running["world"].wait(10)
        services.start("world")  # as `restart: on-failure` does
        after = wait_for(lambda: (state := shown()) and len(state.resumed) == 1 and state)
        assert after.faults == before.faults
        assert after.resumed[0] * 0.01 > before.stamp - SECONDS
    assert "2->3: loss 30 %" in services.text()
    services.execute("control", "stop")
    assert services.running["world"].wait(10) == 0
