"""Laws of several hosts: two of them simulate what one does, bit by bit, and nobody without a code gets in."""

import json
import re
import signal
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from benchmarks.two_hosts import Host, two_hosts
from formation.scenario.files import load
from runtime import inprocess
from tests.exceptions import needs
from tests.processes.live import processes, wait_for

pytestmark = pytest.mark.processes
RING = ["formation.robots=8", "faults=[{preset='bursty'}]", "duration=6"]
WORDS = ["ring-16", *(word for setting in RING for word in ("--set", setting))]
CODE = re.compile(r"echelon join (\S+) (\S+)")


def _over(host: Host) -> bool:
    return not processes(host.runs)


@pytest.fixture
def hosts() -> Iterator[tuple[Host, Host]]:
    needs("network namespaces")
    with tempfile.TemporaryDirectory(prefix="ech") as folder, two_hosts(Path(folder)) as found:
        yield found
        for host in found:
            wait_for(partial(_over, host))
            assert not [path for path in host.runs.iterdir() if path.name[0] != "."]


def test_a_ring_on_two_hosts_is_that_in_one_process_and_its_codes_are_good_once(
    hosts: tuple[Host, Host], tmp_path: Path
) -> None:
    here, there = hosts
    with (tmp_path / "up").open("w+") as log, (tmp_path / "join").open("w+") as joined:
        words = ("--agents", "1-4", "--listen", here.address, "--json")
        run = here.start(log, "run", *WORDS, *words, output=True)
        where, code = wait_for(lambda: CODE.search((tmp_path / "up").read_text())).groups()
        assert where == f"{here.address}:7447"
        folder = next(here.runs.iterdir()) / "keys"
        assert all(path.stat().st_mode & 0o777 == 0o600 for path in folder.iterdir())
        guest = there.start(joined, "join", where, code)
        wait_for(lambda: "running agents 5-8" in (tmp_path / "join").read_text())
        keys = next(there.runs.iterdir()) / "keys"
        assert {path.stem for path in keys.iterdir()} == {"authority", *(f"agent-{robot}" for robot in range(5, 9))}
        assert all(path.stat().st_mode & 0o777 == 0o600 for path in keys.iterdir())
        assert "was used already" in there.echelon("join", where, code, check=2).stderr
        summary = json.loads(run.communicate(timeout=100)[0])
        guest.send_signal(signal.SIGINT)
        assert guest.wait(20) == 0
    alone = inprocess.simulate(load("ring-16", RING))
    assert summary["trajectory_sha256"] == alone["trajectory_sha256"]


def test_an_operator_elsewhere_gives_orders_and_an_observer_only_listens(
    hosts: tuple[Host, Host], tmp_path: Path
) -> None:
    here, there = hosts
    with (tmp_path / "up").open("w+") as log:
        run = here.start(log, "up", "triangle-circle", "--no-dashboard", "--listen", here.address)
        wait_for(lambda: re.search(r"agents? (\S*[-,])?3 (is|are) here", (tmp_path / "up").read_text()))
        connect = ("--connect", here.address)
        assert "echelon invite operator" in there.echelon("status", *connect, check=2).stderr
        observer, operator = (here.echelon("invite", guest).stdout.strip() for guest in ("observer", "operator"))
        assert "for observer" in there.echelon("join", here.address, observer, check=2).stderr
        assert json.loads(there.echelon("status", "--json", *connect, "--code", observer).stdout)["live"] == [1, 2, 3]
        assert "only listens" in there.echelon("fault", "clear", *connect, check=2).stderr
        there.echelon("fault", "set", "--link", "1->2", "--cut", *connect, "--code", operator)
        assert "1->2: cut" in there.echelon("fault", "show", *connect).stdout  # with the keys of the last time
        checks = json.loads(there.echelon("doctor", "--json", *connect).stdout)["checks"]
        found = {check["name"]: check["found"] for check in checks}
        assert float(found["round trip"].split()[0]) < 1000.0
        assert float(found["its clock"].split()[0]) < 1000.0  # it is the same machine
        run.send_signal(signal.SIGINT)
        assert run.wait(20) == 0
