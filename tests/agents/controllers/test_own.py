"""Laws of controllers of users' own: they are like built-in ones, and their mistakes stop one robot alone."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.controllers import own
from agents.controllers.own import load_controller
from formation.errors import ScenarioError
from formation.scenario.files import load
from formation.scenario.registry import CONTROLLERS, live, told
from formation.scenario.scenario import Scenario
from network.control import Reset
from runtime.inprocess import Simulation
from tests.memory_run import MemoryRun
from tests.user_code import clean, hold_slot

__all__ = ["clean", "hold_slot"]
Write = Callable[..., str]


def scenario(name: str, **controller: Any) -> Scenario:
    raw = {"controller": {"name": name, **controller}, "duration": 1.0, "robots": {}}
    return load("triangle-circle", raw)


def test_fifteen_lines_hold_the_triangle_below_a_millimetre(hold_slot: Write) -> None:
    name = load_controller(hold_slot()).name
    simulation = Simulation(load("triangle-circle", {"controller": {"name": name}, "duration": 20, "robots": {}}))
    distance, _, _ = simulation.simulate().errors()
    assert np.abs(distance).max() < 1e-3


def test_nodes_on_a_bus_and_one_process_compute_the_same(hold_slot: Write) -> None:
    name = load_controller(hold_slot()).name
    task = load("triangle-circle", {"controller": {"name": name}, "duration": 0.3, "link": {"latency": 0.05}})
    run = MemoryRun(task)
    run.run(30.0, lambda: run.world.finished)
    np.testing.assert_array_equal(run.world.trace.poses, Simulation(task).simulate().poses)  # type: ignore[union-attr]


def test_it_is_listed_like_a_built_in_one(hold_slot: Write) -> None:
    name = load_controller(hold_slot()).name
    assert name == "HoldSlot"
    assert name in live()
    assert name in told()
    assert load("circle", {"controller": {"name": name, "horizon": 7}}).controller.horizon == 7


def test_two_classes_of_one_name_in_two_folders_are_two_controllers(hold_slot: Write) -> None:
    names = [load_controller(hold_slot(folder=folder)).name for folder in ("a", "b", "a")]
    assert names == ["HoldSlot", "HoldSlot-2", "HoldSlot"]
    assert scenario("HoldSlot-2").controller.name == "HoldSlot-2"


def test_the_name_of_a_built_in_one_is_refused(hold_slot: Write) -> None:
    with pytest.raises(ScenarioError, match="expected a class with a name of its own; got nash, which is built in"):
        load_controller(hold_slot(name="nash"))
    assert CONTROLLERS["nash"].code is None


def test_data_names_no_code(hold_slot: Write) -> None:
    spec = hold_slot()
    with pytest.raises(ScenarioError, match=r"controller.name: expected one of nash.*--controller FILE.py:CLASS"):
        load("circle", {"controller": {"name": spec}})


OPTIONS = """
from pydantic import BaseModel, Field
class Keyed(HoldSlot):
    class Options(BaseModel):
        gain: float = Field(1.0, gt=0.0)
        horizon: int = 9
    ages_plans = False
    colour = "#ABCDEF"
"""


def test_its_own_keys_are_checked_like_those_of_built_in_ones(hold_slot: Write) -> None:
    file = hold_slot(more=OPTIONS).rpartition(":")[0]
    name = load_controller(f"{file}:Keyed").name
    made: Any = scenario(name, gain=3.0).controller
    assert (made.gain, made.horizon, made.plan_every) == (3.0, 9, 1)
    assert Scenario.model_validate_json(scenario(name, gain=3.0).model_dump_json()).controller == made
    for key, value, line in (
        ("gain", -1.0, "controller.gain: expected more than 0; got -1.0"),
        ("gain", "much", "controller.gain: expected a number"),
        ("gian", 1.0, r"controller.gian: unknown key: .*did you mean gain"),
        ("formation", 1.0, "controller.formation: unknown key: .*it is a key of nash"),
        ("plan_every", 0, "controller.plan_every: expected at least 1"),
    ):
        with pytest.raises(ScenarioError, match=line):
            scenario(name, **{key: value})
    assert not CONTROLLERS[name].ages_plans
    assert CONTROLLERS[name].colour == "ABCDEF"


TAKES = "def __init__(self, task, options): ..."
PLANS = "def plan(self, observation): ..."
WRONG = {
    "pass": r"expected a method plan\(observation\); it has no method",
    "def step(self): ...": r"expected a method plan\(observation\); it has step",
    PLANS: r"expected Mine\(task, options\); it has Mine\(",
    f"{TAKES}\n    def plan(self): ...": r"expected plan\(observation\); it has plan\(\)",
    f"{TAKES}\n    {PLANS}\n    Options = 3": "expected a pydantic model as Options; it has 3",
    f"{TAKES}\n    {PLANS}\n    ages_plans = 'no'": "expected ages_plans to be True or False; it has 'no'",
    f"{TAKES}\n    {PLANS}\n    colour = 'red'": "expected colour to be six hexadecimal digits; it has 'red'",
    f"{TAKES}\n    {PLANS}\n    protocol = 99": "expected protocol = 1; it has 99",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_class_that_is_no_controller_gets_one_line(text: str, tmp_path: Path, clean: None) -> None:
    (tmp_path / "mine.py").write_text(f"class Mine:\n    {text}\n")
    with pytest.raises(ScenarioError, match=rf"^mine.py:Mine: {WRONG[text]}") as mistake:
        load_controller(f"{tmp_path}/mine.py:Mine")
    assert "\n" not in str(mistake.value)


FAILURES = {
    "1 / 0": r"ZeroDivisionError: division by zero \(mine.py:9\)",
    "raise SystemExit": r"SystemExit \(mine.py:9\)",
    "return None": r"expected plan to return a Solution; got None \(mine.py:8\)",
    "return Solution(np.zeros((3, 2)))": r"expected inputs of shape \(20, 2\); got \(3, 2\) \(mine.py:8\)",
    "return Solution('x')": r"ValueError: could not convert string to float",
    "return Solution(np.full((20, 2), np.nan))": r"expected finite inputs; got nan \(mine.py:8\)",
    "return Solution(np.full((20, 2), 0.05 + 0.01j))": r"expected real inputs; got complex numbers \(mine.py:8\)",
    "return Solution(np.full((20, 2), 50.0))": r"expected inputs within 10 times the limits; got 100 times",
    "observation.pose[0] = 1.0": r"ValueError: assignment destination is read-only \(mine.py:9\)",
    "observation.upstream.inputs[0] = 1.0": r"ValueError: assignment destination is read-only \(mine.py:9\)",
}


@pytest.mark.parametrize("mistake", FAILURES)
def test_a_failure_stops_its_robot_with_an_event_and_the_run_goes_on(mistake: str, hold_slot: Write) -> None:
    name = load_controller(hold_slot(f"if observation.k == 20 and self.task.robot == 2: {mistake}")).name
    simulation = Simulation(scenario(name))
    inputs = simulation.simulate().inputs
    assert inputs[:20, 1].any(axis=1).all()
    assert not inputs[20:, 1].any()
    assert inputs[:, [0, 2], 0].all()
    (event,) = [event for event in simulation.world.events if event.kind == "agent"]
    assert (event.stamp, event.severity) == (0.2, "error")
    begins = "robot 2 stands still and publishes no plan until a reset: HoldSlot: "
    assert re.match(begins + FAILURES[mistake], event.text), event.text
    held = simulation.agents[3].observation
    assert held is not None
    assert held.upstream.plan is not None
    assert held.upstream.plan.seq == 19


def test_a_failure_stops_the_same_robot_at_the_same_tick_on_a_bus_and_a_reset_lets_it_begin_again(
    hold_slot: Write,
) -> None:
    name = load_controller(hold_slot("if observation.k == 10 and self.task.robot == 2: 1 / 0")).name
    task = load("triangle-circle", {"controller": {"name": name}, "duration": 0.3})
    run = MemoryRun(task)
    run.run(30.0, lambda: run.world.finished)
    alone = Simulation(task)
    np.testing.assert_array_equal(run.world.trace.poses, alone.simulate().poses)  # type: ignore[union-attr]
    failures = [
        [(e.stamp, e.text) for e in world.events if "publishes no plan" in e.text] for world in (run.world, alone.world)
    ]
    assert failures[0] == failures[1] != []
    run.ask(Reset())
    run.run(5.0, lambda: run.world.k == 5)
    assert run.counted[-1] == {1, 2, 3}
    assert run.world.trace.inputs[:5, 1].any(axis=1).all()  # type: ignore[union-attr]


def test_one_that_cannot_be_made_stands_from_the_start(hold_slot: Write) -> None:
    file, _, _ = hold_slot(
        more="\nclass Broken(HoldSlot):\n    def __init__(self, task, options):\n        {}['x']\n"
    ).rpartition(":")
    simulation = Simulation(scenario(load_controller(f"{file}:Broken").name))
    assert not simulation.simulate().inputs.any()
    assert sum("KeyError: 'x' (mine.py" in event.text for event in simulation.world.events) == 3


def test_an_agent_with_another_text_takes_no_part(hold_slot: Write) -> None:
    name = load_controller(hold_slot()).name
    task = scenario(name)
    run = MemoryRun(task)
    setup = run.world.setup()
    own.check_loaded(setup.user_code, name)
    load_controller(hold_slot("x = 1"))
    with pytest.raises(ScenarioError, match=r"controller HoldSlot: expected mine.py:HoldSlot of SHA-256 .*got that of"):
        own.check_loaded(setup.user_code, name)


def test_an_installed_package_names_its_controllers_by_entry_points(
    hold_slot: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What pip leaves behind of a package: its module, and its entry points."""
    file = Path(hold_slot(name="Held").partition(":")[0])
    site = tmp_path / "site"
    (site / "held-1.0.dist-info").mkdir(parents=True)
    file.rename(site / "held_module.py")
    (site / "held-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: held\nVersion: 1.0\n")
    (site / "held-1.0.dist-info" / "entry_points.txt").write_text("[echelon.controllers]\nheld = held_module:Held\n")
    monkeypatch.syspath_prepend(site)
    name = load_controller("held").name
    trace = Simulation(load("triangle-circle", {"controller": {"name": name}, "duration": 3, "robots": {}})).simulate()
    assert np.abs(trace.errors()[0][-1]).max() < 1e-3
    with pytest.raises(ScenarioError, match=r"expected FILE\.py:CLASS or package\.module:CLASS"):
        load_controller("helt")
