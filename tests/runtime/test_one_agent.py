"""Laws of one agent anew: with the controller that it had it does what it did, to the last bit."""

import json
from pathlib import Path
from typing import Any

import pytest

from cli.main import main
from formation.errors import EchelonError
from network.interventions import Reshape
from records.record import load
from runtime.one_agent import rerun
from tests.records.recorded import record, scenario
from world.world import World

PUSHED = "disturbances=[{robot=2, at=0.5, until=1, drift=[0.05, 0, 0]}]"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same episode recorded in lockstep and, in full, as one of real time."""
    folder = tmp_path_factory.mktemp("agents")
    record(folder / "lockstep.mcap", scenario(PUSHED))
    record(folder / "realtime.mcap", scenario(PUSHED), "full", mode="realtime")
    record(folder / "short.mcap", scenario("duration=0.2"), mode="realtime")
    return {path.stem: path for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["lockstep", "realtime"])
@pytest.mark.parametrize("robot", [1, 2, 3])
def test_the_same_controller_does_what_was_done(files: Any, name: str, robot: int) -> None:
    found = rerun(load(files[name]), robot)
    assert (found.first, found.largest, found.rms) == (None, (0.0, 0.0), (0.0, 0.0))
    assert found.ticks == 250


@pytest.mark.parametrize("shape", ["keep", "close"])
@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
@pytest.mark.parametrize("leave", [0, 0.7])
def test_a_ring_that_closes_and_opens_is_the_agents_too(tmp_path: Path, shape: str, mode: Any, leave: float) -> None:
    """Whoever has another neighbour begins anew there; with another shape everybody's place is another."""
    away = f"membership={{shape='{shape}', changes=[{{robot=2, leave={leave}, join=1.8}}]}}"
    ring = scenario("formation.robots=4", "bodies=camera", away, name="ring-16")
    record(tmp_path / "ring.mcap", ring, "full", mode=mode)
    kept = load(tmp_path / "ring.mcap")
    for robot in (1, 2, 3):
        found = rerun(kept, robot)
        assert (robot, found.first, found.largest) == (robot, None, (0.0, 0.0))
        assert found.ticks == 250


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_shape_that_a_user_ordered_is_the_agents_too(tmp_path: Path, mode: Any) -> None:
    def order(world: World) -> None:
        if world.k == 60:
            world.intervene(Reshape(shape="line"))

    record(tmp_path / "line.mcap", scenario(), "full", mode=mode, before=order)
    found = rerun(load(tmp_path / "line.mcap"), 1)
    assert (found.first, found.ticks) == (None, 250)


@pytest.mark.parametrize("controller", ["consensus", "leader_follower"])
def test_another_controller_differs_alike_whatever_kind_of_record(files: Any, controller: str) -> None:
    one, other = (rerun(load(files[name]), 2, controller) for name in ("lockstep", "realtime"))
    assert one == other
    assert one.first is not None
    assert 0.0 < one.rms[0] <= one.largest[0]


def test_the_command_prints_what_came_of_it(files: Any, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["recording", "agent", str(files["lockstep"]), "--robot", "2"]
    assert main(words) == 0
    assert "robot 2, 250 ticks: every command is equal" in capsys.readouterr().out
    assert main(["replay", str(files["lockstep"]), "--agent", "2"]) == 0
    assert "robot 2, 250 ticks: every command is equal" in capsys.readouterr().out
    assert main([*words, "--controller", "consensus", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["first"] is not None


@pytest.mark.parametrize(
    ("name", "robot", "controller", "reason"),
    [
        ("lockstep", 4, "", "1 to 3"),
        ("lockstep", 2, "nobody", "expected one of"),
        ("short", 2, "", "--detail full"),
    ],
)
def test_what_cannot_be_run_is_one_line(files: Any, name: str, robot: int, controller: str, reason: str) -> None:
    with pytest.raises(EchelonError, match=reason):
        rerun(load(files[name]), robot, controller)
