"""Code of users' own in a run of processes: one hash in both engines, as ghost, by the text read at the start."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formation.scenario.registry import BUILT_IN
from network.zenoh_bus import ZenohBus
from runtime.run_registry import find
from tests.processes.live import Up, echelon, wait_for
from tests.processes.test_compare import Ears
from tests.user_code import clean, hold_slot
from tests.world.bodies.test_own import BODY

__all__ = ["clean", "hold_slot"]
pytestmark = pytest.mark.processes
Write = Callable[..., str]
Start = Callable[..., Up]


def summary(engine: str, *words: str) -> dict[str, Any]:
    done = echelon("run", "triangle-circle", "--engine", engine, "--duration", "3", "--json", *words)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_both_engines_give_one_hash(hold_slot: Write, runs: Path) -> None:
    body = Path(hold_slot().partition(":")[0]).with_name("puck.py")
    body.write_text(BODY.format(mistake="pass"))
    words = ("--controller", hold_slot(), "--bodies", f"{body}:Puck", "--set", "link.latency=0.05")
    found = [summary(engine, *words) for engine in ("inprocess", "processes")]
    assert len({one["trajectory_sha256"] for one in found}) == 1
    assert len({json.dumps(one["user_code"]) for one in found}) == 1
    assert {code["origin"] for code in found[0]["user_code"]} == {"mine.py:HoldSlot", "puck.py:Puck"}


def test_a_failure_is_the_same_event_in_both_engines(hold_slot: Write, runs: Path) -> None:
    words = ("--controller", hold_slot("if observation.k == 50 and self.task.robot == 2: 1 / 0"))
    found = [summary(engine, *words) for engine in ("inprocess", "processes")]
    assert len({one["trajectory_sha256"] for one in found}) == 1
    failures = [[e for e in one["events"] if "division by zero (mine.py:9)" in e["text"]] for one in found]
    assert failures[0] == failures[1]
    assert [event["t"] for event in failures[0]] == [0.5]


def test_it_runs_beside_another_as_a_ghost_and_a_restarted_agent_has_the_text_of_the_start(
    hold_slot: Write, up: Start
) -> None:
    spec = hold_slot()
    run = up("triangle-circle", "--no-dashboard", "--controller", "nash", "--controller", spec)
    run.running()
    hold_slot("1 / 0")
    with ZenohBus(find("test").endpoint, "test") as session:
        setup = session.setup()
        assert setup is not None
        assert [code.name for code in setup.user_code] == ["HoldSlot"]
        ears = Ears(session)
        echelon("control", "compare", "HoldSlot")
        pairs = wait_for(lambda: ears.pairs("HoldSlot"))
        assert all(np.isfinite(ghost.poses).all() for _, ghost in pairs)
        echelon("control", "controller", "HoldSlot")
        echelon("control", "restart", "2")
        wait_for(lambda: (s := run.status()) and s["controller"] == "HoldSlot" and s["live"] == [1, 2, 3])
        time.sleep(0.5)
        assert not run.status()["stopped"]
        assert "division by zero" not in run.text()


def test_a_name_that_nobody_loaded_is_refused_with_the_option_to_type(runs: Path) -> None:
    done = echelon("run", "circle", "--set", "controller.name=HoldSlot", check=2)
    assert len(done.stderr.splitlines()) == 1
    for word in ("HoldSlot", "--controller FILE.py:CLASS", *BUILT_IN):
        assert word in done.stderr
