"""Two hosts: network namespaces joined by a cable (a veth pair), with addresses of their own; removed in the end."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

ADDRESSES = ("10.231.77.1", "10.231.77.2")


@dataclass(frozen=True, slots=True)
class Host:
    """One of the two."""

    namespace: str
    address: str
    runs: Path
    """Its folder for runs; short, because of the sockets in it."""
    started: list[subprocess.Popen[str]] = field(default_factory=list)

    def inside(self, *words: str) -> list[str]:
        """The words as a command on this host."""
        return ["ip", "netns", "exec", self.namespace, *words]

    def start(self, log: IO[str], *words: str, output: bool = False) -> subprocess.Popen[str]:
        """An echelon command that goes on; with `output` what it prints on stdout can be read."""
        command = self.inside(sys.executable, "-m", "cli.main", *words)
        out = subprocess.PIPE if output else log
        self.started.append(subprocess.Popen(command, env=self._environment, text=True, stdout=out, stderr=log))
        return self.started[-1]

    def echelon(self, *words: str, check: int = 0) -> subprocess.CompletedProcess[str]:
        """Run an echelon command to its end."""
        command = self.inside(sys.executable, "-m", "cli.main", *words)
        done = subprocess.run(command, env=self._environment, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == check, done.stderr
        return done

    def run(self, *words: str, text: str | None = None) -> None:
        """Run any command to its end."""
        subprocess.run(self.inside(*words), input=text, text=True, check=True)

    @property
    def _environment(self) -> dict[str, str]:
        return {**os.environ, "ECHELON_RUNS": str(self.runs)}


@contextmanager
def two_hosts(folder: Path) -> Iterator[tuple[Host, Host]]:
    """Make them; they go whatever happens."""
    names = [f"ech{os.getpid()}{letter}" for letter in "ab"]
    ends = [f"v{os.getpid()}{letter}" for letter in "ab"]
    hosts: list[Host] = []
    try:
        for name in names:
            _ip("netns", "add", name)
        _ip("link", "add", ends[0], "netns", names[0], "type", "veth", "peer", "name", ends[1], "netns", names[1])
        for name, end, address in zip(names, ends, ADDRESSES, strict=True):
            _ip("-n", name, "addr", "add", f"{address}/24", "dev", end)
            for device in ("lo", end):
                _ip("-n", name, "link", "set", device, "up")
            runs = folder / name[-1]
            runs.mkdir(mode=0o700)
            hosts.append(Host(name, address, runs))
        yield hosts[0], hosts[1]
    finally:
        for process in [process for host in hosts for process in host.started]:
            process.kill()
            process.communicate()
        for name in names:
            with suppress(subprocess.CalledProcessError):
                _ip("netns", "del", name)


def lose(host: Host, port: int, percent: int) -> None:
    """From now on so much of what comes to this port of a host is lost, until the table `loss` is deleted.

    On arrival: of what is dropped where it is sent, the sender's TCP would know.
    """
    chain = f"type filter hook input priority 0; th dport {port} numgen random mod 100 < {percent} drop;"
    host.run("nft", "-f", "-", text=f"table inet loss {{\nchain received {{\n{chain}\n}}\n}}\n")


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True)
