"""The services of compose.yaml, each by its very command, from another folder; only where they meet differs."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
import yaml

from network import topics
from network.access.keys import Keys
from network.codec import decode
from network.messages import State
from network.zenoh_bus import ZenohBus
from runtime.compose import KEYS, ROUTER_PORT, RUN, SAVED, plan
from tests.processes.live import compiled, title, wait_for
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
        self._here |= {KEYS: str(folder / "keys"), plan("triangle-circle", {}).scenario: "triangle-circle"}
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

    def start(self, name: str, *more: str, number: int = 1) -> None:
        """Start a service, or with more arguments another container of it."""
        words = [*(self._own(word) for word in self._services[name]["command"]), *more]
        assert words[0] == "python"
        self.running[name if number == 1 else f"{name}-{number}"] = subprocess.Popen(
            [sys.executable, *words[1:]], cwd=self._folder, env=self.environment(name), text=True, stderr=self.log
        )

    def start_all(self) -> None:
        """Keys and router first: without it the others would wait, each a little longer after every attempt."""
        self.start("keys")
        assert self.running.pop("keys").wait(30) == 0
        self.start("router")
        wait_for(lambda: self.healthy("router"))
        for name in self._services:
            if name not in ("keys", "router"):
                self.start(name)

    def session(self) -> ZenohBus:
        own = self.environment("world")
        return ZenohBus(own["ECHELON_CONNECT"], RUN, keys=Keys.of(Path(own["ECHELON_KEYS"]), "observer"))

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

    def agents_of(self, name: str) -> set[int]:
        """Robots whose agents a service runs."""
        children = psutil.Process(self.running[name].pid).children(recursive=True)
        return {int(one.split()[-1]) for one in map(title, children) if ": agent " in one}

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
    with services.session() as session:
        states = session.keep(topics.state(RUN), 1)
        newest: list[State] = []

        def shown() -> State | None:
            newest[:] = [decode(State, sample.payload) for sample in states.take()] or newest
            return newest[-1] if newest else None

        wait_for(lambda: (state := shown()) and state.stamp > 0.5, seconds=90.0)  # each process imports numba
        assert services.healthy("agents")
        services.execute("fault", "set", "--link", "2->3", "--loss", "30%")
        before = wait_for(lambda: (state := shown()) and state.faults and state)
        services.running["world"].send_signal(signal.SIGKILL)
        services.running["world"].wait(10)
        services.start("world")  # as `restart: on-failure` does
        after = wait_for(lambda: (state := shown()) and len(state.resumed) == 1 and state)
        assert after.faults == before.faults
        assert after.resumed[0] * 0.01 > before.stamp - SECONDS
        wait_for(lambda: (state := shown()) and len(state.live) == 3)
        services.execute("control", "restart", "2")  # who keeps agents is there for the new world too
        # As `--scale agents=2`: the second one takes its share, also of a scenario with more robots.
        services.start("agents", "--id", "0", number=2)
        services.execute("control", "scenario", "square-figure8")
        shares = {frozenset({1, 3}), frozenset({2, 4})}
        wait_for(
            lambda: {frozenset(services.agents_of(name)) for name in ("agents", "agents-2")} == shares, seconds=60.0
        )
        wait_for(lambda: (state := shown()) and state.live == [1, 2, 3, 4], seconds=60.0)
    assert "2->3: loss 30 %" in services.text()
    services.execute("control", "stop")
    assert services.running["world"].wait(10) == 0
