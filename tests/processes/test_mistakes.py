"""A person's mistake is one line that says what there is to choose from; exit code 2, and nothing is left over."""

import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.processes.live import Up, echelon, processes

pytestmark = pytest.mark.processes

MISTAKES = {
    "scenario": (["run", "cirle"], ["scenario", "cirle", "figure8", "did you mean circle"]),
    "file": (["run", "nowhere.toml"], ["nowhere.toml"]),
    "controller": (["run", "--controller", "nsh"], ["controller.name", "nash", "paper", "leader_follower"]),
    "no process": (["run", "--controller", "centralised"], ["controller.name", "--engine inprocess", "nash"]),
    "preset": (["run", "--faults", "wify"], ["wifi", "congested", "wify"]),
    "key": (["run", "--set", "link.latncy=1"], ["link.latncy", "latency"]),
    "range": (["run", "--set", "link.loss=2"], ["link.loss", "at most 1", "2"]),
    "link in a schedule": (["run", "--set", "faults=[{link='1->9'}]"], ["faults[0].link", "1->2"]),
    "warmup": (["run", "--duration", "5", "--warmup", "9"], ["--warmup", "5", "9"]),
    "speed": (["up", "--speed", "-1"], ["--speed", "-1"]),
    "run name": (["up", "--run", "a/b"], ["--run", "a/b"]),
    "no run for status": (["status"], ["echelon up"]),
    "no run for fault": (["fault", "clear"], ["echelon up"]),
    "no run for control": (["control", "pause"], ["echelon up"]),
    "nothing to set": (["fault", "set"], ["--latency"]),
    "fault out of range": (["fault", "set", "--loss", "300%"], ["loss", "at most 1"]),
    "time that is none": (["fault", "set", "--cut", "--for", "soon"], ["seconds", "300ms", "soon"]),
    "no time at all": (["fault", "preset", "wifi", "--for", "0s"], ["seconds", "more than 0"]),
    "tick of nothing": (["run", "--set", "control_interval=1e-310"], ["prediction_interval"]),
    "duration for ever": (["run", "--set", "duration=1e9"], ["duration", "10000"]),
    "deep nonsense": (["run", "--set", "seed=" + "[" * 3000], ["seed"]),
    "deep key": (["run", "--set", ".".join("a" * 3000) + "=1"], ["--set", "a.a.a"]),
    "spacing for ever": (["run", "--set", "formation.spacing=1e308"], ["formation.spacing", "at most 1e+09"]),
    "too wide to turn": (["run", "--set", "formation.spacing=1e5"], ["formation", "20000 s"]),
    "nobody there": (["status", "--connect", "tcp/127.0.0.1:1", "--insecure"], ["router", "tcp/127.0.0.1:1"]),
    "open to strangers": (["status", "--connect", "tcp/127.0.0.1:1"], ["tls/HOST:7447", "--insecure"]),
    "no keys": (["status", "--connect", "127.0.0.1:1"], ["--code", "echelon invite operator"]),
    "nobody to join": (["join", "127.0.0.1:1", "ABCD-EFGH-JKLM-NPQR-STUV"], ["127.0.0.1:2", "echelon up --listen"]),
    "no code": (["join", "127.0.0.1:1", "ABCD-EFGH-JKLM-NPQR-STU0"], ["20 letters", "0, O, 1 and I"]),
    "without a code": (["join", "127.0.0.1:1"], ["echelon invite agents"]),
    "agents of nobody": (["up", "--agents", "1-2"], ["--agents", "--listen"]),
    "agents without sense": (["up", "--listen", "127.0.0.1", "--agents", "2-x"], ["1 to 1024", "2-x"]),
    "another's address": (["up", "--listen", "192.0.2.1"], ["--listen", "192.0.2.1"]),
    "invite to nothing": (["invite", "operator"], ["echelon up"]),
    "guest": (["invite", "king"], ["agents", "operator", "observer", "king"]),
    "command": (["fly"], ["fly", "scenarios"]),
    "number": (["up", "--port", "eighty"], ["--port", "eighty"]),
    "engine": (["run", "--engine", "steam"], ["processes", "inprocess", "steam"]),
    "compose of a file": (["compose", "my.toml"], ["my.toml", "triangle-circle"]),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_one_line_with_the_choices(runs: Path, case: str) -> None:
    words, expected = MISTAKES[case]
    done = echelon(*words, check=2)
    assert done.stdout == ""
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    for text in expected:
        assert text in lines[0]
    assert not list(runs.iterdir())
    assert not processes(runs)


def test_a_file_gets_one_line_per_mistake(runs: Path) -> None:
    file = runs / "bad.toml"
    file.write_text('name = "bad"\nseed = -1\n[path]\nkind = "circle"\nradius = -2\n[formation]\nshape = "blob"\n')
    lines = echelon("run", str(file), check=2).stderr.strip().splitlines()
    assert len(lines) == 3
    assert all(key in text for key, text in zip(("seed", "path.radius", "formation.shape"), lines, strict=True))


def test_a_taken_port_is_an_error(runs: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        lines = echelon("up", "--port", port, check=2).stderr.strip().splitlines()
    assert len(lines) == 1
    assert port in lines[0]
    assert not processes(runs)


def test_names_links_and_presets_of_a_live_run_are_checked(up: Callable[..., Up]) -> None:
    run = up("--no-dashboard")
    run.running()
    for words, expected in (
        (["up", "--run", "test", "--no-dashboard"], "not in use"),
        (["fault", "set", "--link", "1->3", "--cut"], "1->2, 2->3, 3->1"),
        (["fault", "preset", "wify"], "wifi"),
        (["control", "scenario", "nothing"], "triangle-circle"),
        (["control", "controller", "nothing"], "leader_follower"),
        (["control", "controller", "centralised"], "--engine inprocess"),
        (["status", "--run", "other"], "test"),
    ):
        done = echelon(*words, check=2)
        assert expected in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1
    assert run.running()["faults"] == {}
    run.end()
