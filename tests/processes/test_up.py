"""A live run: what dies comes back, and nothing is left behind however it ends."""

import contextlib
import os
import re
import signal
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest

from network import topics
from network.values import Event
from network.zenoh_bus import ZenohBus
from tests import builders
from tests.processes.live import Up, echelon, processes, title, wait_for

pytestmark = pytest.mark.processes
Start = Callable[..., Up]


def texts(up: Up) -> list[str]:
    return [event["text"] for event in up.status().get("events", [])]


def test_a_killed_agent_is_noticed_its_robot_stops_and_it_comes_back(up: Start) -> None:
    run = up("--no-dashboard")
    run.running()
    os.kill(run.pid("agent 2"), signal.SIGKILL)
    wait_for(lambda: texts(run).count("agent 2 is here") == 2)
    seen = texts(run)
    lost, back = seen.index("agent 2 lost"), len(seen) - 1 - seen[::-1].index("agent 2 is here")
    assert lost < back
    assert run.status()["stamp"] > 0

    def closed() -> bool:
        state = run.status()
        return bool(state) and not state["stopped"] and max(abs(e) for e in state["distance_errors"]) < 2e-3

    wait_for(closed)
    run.end()


def test_an_agent_that_a_person_kills_stays_down_until_it_is_restarted(up: Start, runs: Path) -> None:
    run = up("--no-dashboard")
    run.running()
    pid = run.pid("agent 2")

    def agents() -> list[int]:
        titles = [title(process) for process in processes(runs)]
        return [i for i in (1, 2, 3) if f"echelon test: agent {i}" in titles]

    for _ in range(2):
        echelon("control", "kill", "2")
        wait_for(lambda: (s := run.status()) and s["live"] == [1, 3] and s["dismissed"] == [2])
        assert agents() == [1, 3]
        before = run.status()["stamp"]
        wait_for(lambda: run.status()["stamp"] > before + 0.5)  # noqa: B023
        assert run.status()["stopped"] == [2]
        assert agents() == [1, 3]
        echelon("control", "restart", "2")
        wait_for(lambda: run.status()["live"] == [1, 2, 3])
        assert run.status()["dismissed"] == []
    fresh = run.pid("agent 2")
    assert fresh != pid
    echelon("control", "restart", "2")  # one that lives is replaced
    wait_for(lambda: run.pid("agent 2") != fresh and run.status()["live"] == [1, 2, 3])
    assert "expected a number" in echelon("control", "kill", "two", check=2).stderr
    assert "1 to 3; got 4" in echelon("control", "kill", "4", check=2).stderr
    run.end()


def test_of_agents_that_share_a_process_one_can_be_killed_and_brought_back(up: Start) -> None:
    run = up("--no-dashboard", "--together", "2")
    run.running()
    pid = run.pid("agents 1-2")
    echelon("control", "kill", "2")
    wait_for(lambda: run.status()["dismissed"] == [2] and run.status()["live"] == [1, 3])
    assert run.pid("agent 1") != pid
    assert "agent 2 killed, as asked, with its process; starting again: agent 1" in run.text()
    echelon("control", "restart", "2")
    wait_for(lambda: run.status()["live"] == [1, 2, 3])
    run.end()


def test_a_killed_router_costs_seconds_and_nothing_else(up: Start) -> None:
    run = up("--no-dashboard")
    before = run.running()
    os.kill(run.pid("router"), signal.SIGKILL)
    wait_for(lambda: "router is back" in texts(run))
    after = run.running()
    assert after["episode"] == before["episode"]
    assert "agent 1 lost" not in texts(run)
    wait_for(lambda: run.status()["stamp"] > after["stamp"] + 0.5)
    run.end()


def test_a_killed_dashboard_comes_back_at_the_same_address(up: Start) -> None:
    run = up("--port", "0")
    run.running()
    address = wait_for(lambda: re.search(r"dashboard: (http://\S+)", run.text()))[1]

    def answers() -> bool:
        with contextlib.suppress(OSError), urllib.request.urlopen(address, timeout=5) as page:
            return bool(page.status == 200)
        return False

    wait_for(answers)
    os.kill(run.pid("dashboard"), signal.SIGKILL)
    wait_for(lambda: run.text().count(f"dashboard: {address}") == 2)
    wait_for(answers)
    assert run.end() == 0
    assert not answers()


def test_an_agent_that_hangs_is_left_behind_and_taken_back(up: Start) -> None:
    run = up("--no-dashboard")
    run.running()
    pid = run.pid("agent 3")
    os.kill(pid, signal.SIGSTOP)
    try:
        wait_for(lambda: 3 not in run.status().get("live", [3]))
    finally:
        os.kill(pid, signal.SIGCONT)
    wait_for(lambda: run.status().get("live") == [1, 2, 3])
    run.end()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ending_it_leaves_nothing(up: Start, runs: Path, number: int) -> None:
    run = up("--no-dashboard")
    run.running()
    assert len(processes(runs)) >= 6  # launcher, router, world and three agents are seen at all
    assert run.end(number) == 0
    assert [path.name for path in runs.iterdir()] == ["up.log"]
    # the fork server itself goes a moment after its last client
    wait_for(lambda: not processes(runs), 5.0)


def test_killing_it_leaves_nothing_after_five_seconds(up: Start, runs: Path) -> None:
    run = up("--no-dashboard")
    run.running()
    assert len(processes(runs)) >= 6
    run.end(signal.SIGKILL)
    wait_for(lambda: not processes(runs), 5.0)
    assert [path.name for path in runs.iterdir()] == ["up.log"]


def test_another_scenario_with_more_robots_gets_its_agents(up: Start) -> None:
    run = up("circle", "--no-dashboard")
    run.running()
    echelon("control", "scenario", "square-figure8")
    wait_for(lambda: run.status().get("live") == [1, 2, 3, 4])
    assert run.running()["scenario"] == "square-figure8"
    run.end()


def test_time_obeys_the_commands(up: Start) -> None:
    run = up("--no-dashboard")
    run.running()
    echelon("control", "pause")
    held = run.status()["stamp"]
    time.sleep(0.3)
    assert run.status()["stamp"] == held
    echelon("control", "step", "7")
    assert wait_for(lambda: (s := run.status()["stamp"]) > held and s) == pytest.approx(held + 0.07)
    echelon("control", "reset")
    assert run.status()["stamp"] == 0.0
    echelon("control", "speed", "5")
    echelon("control", "start")
    wait_for(lambda: run.status()["pace"] > 1.5)
    echelon("control", "stop")
    assert run.process.wait(20) == 0


def test_faults_are_set_expire_and_clear(up: Start) -> None:
    run = up("--no-dashboard")
    run.running()
    echelon("fault", "set", "--link", "1->2", "--latency", "300ms", "--loss", "30%", "--burst", "5")
    assert run.status()["faults"] == {"1->2": {"latency": 0.3, "loss": 0.3, "burst": 5.0}}
    echelon("fault", "preset", "wifi", "--link", "2->3", "--for", "6s")
    assert set(run.status()["faults"]) == {"1->2", "2->3"}
    wait_for(lambda: set(run.status()["faults"]) == {"1->2"})
    echelon("fault", "clear")
    assert run.status()["faults"] == {}
    assert "healthy" in echelon("fault", "show").stdout
    run.end()


def test_in_real_time_a_short_episode_runs_to_its_end(runs: Path) -> None:
    words = ["run", "--duration", "3", "--realtime", "--json"]
    assert '"overruns"' in echelon(*words).stdout
    assert not list(runs.iterdir())


def test_a_formation_is_driven_by_commands_and_refuses_what_makes_no_sense(up: Start) -> None:
    run = up("drive-me", "--no-dashboard")
    run.running()
    assert "fast as it can" in echelon("control", "drive", "-9", "0.2").stdout
    wait_for(lambda: run.status()["driving"]["v"] < 0.0)
    echelon("control", "goto", "-0.1", "0.1")
    wait_for(lambda: "arrives at (-0.100, 0.100) m" in texts(run))
    assert run.status()["driving"]["goal"] is None
    assert "path.kind" not in echelon("control", "drive", "1", "x", check=2).stderr
    assert "seconds" in echelon("control", "drive", "1", "1", "--for", "-3", check=2).stderr
    echelon("control", "scenario", "circle")
    assert "drive-me" in echelon("control", "goto", "1", "1", check=2).stderr
    run.end()


def test_a_token_may_begin_with_a_dash_and_is_in_no_list_of_processes(up: Start, runs: Path) -> None:
    token = "-" + "a" * 20
    run = up("triangle-circle", "--port", "0", "--host", "0.0.0.0", f"--token={token}")
    wait_for(lambda: re.search(r"dashboard: http://\S+token=-aaa", run.text()))
    assert not [process for process in processes(runs) if token in title(process)]
    assert run.end() == 0
    assert "Traceback" not in run.text()


def test_a_forged_state_costs_seconds_and_no_agent_is_left_over(up: Start, runs: Path) -> None:
    run = up("--no-dashboard")
    run.running()
    event = Event(10**6, 0.0, "run", "\x1b[2Jforged")
    forged = [
        builders.state(10, waiting_for=list(range(1, 11)), events=(event,)),
        builders.state(1, dismissed=[1], events=(event,)),
    ]
    with ZenohBus(f"unixsock-stream/{runs}/test/router.sock", "test") as stranger:
        stranger.announce(topics.state("test"))
        for state in forged * 5:
            stranger.publish(topics.state("test"), state)
            time.sleep(0.03)

    def agents() -> list[str]:
        titles = map(title, processes(runs))
        return sorted(one for one in titles if one.startswith("echelon test: agent"))

    wait_for(lambda: agents() == [f"echelon test: agent {i}" for i in (1, 2, 3)] and run.status()["live"] == [1, 2, 3])
    time.sleep(0.5)
    assert len(agents()) == 3
    assert "\x1b" not in run.text()
    assert run.end() == 0


def test_a_world_that_is_terminated_from_outside_is_started_again(up: Start) -> None:
    run = up("--no-dashboard")
    run.running()
    pid = run.pid("world")
    os.kill(pid, signal.SIGTERM)
    wait_for(lambda: run.pid("world") != pid and run.status().get("live") == [1, 2, 3])
    assert run.process.poll() is None
    assert run.end() == 0
