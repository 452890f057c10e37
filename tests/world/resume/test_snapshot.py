"""Laws of a saved run: what goes on from it does the same to the last bit, and foreign bytes run nothing."""

import contextlib
import os
import pickle
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.faults import PERFECT, Fault
from formation.scenario.files import load as load_scenario
from formation.scenario.scenario import Scenario
from network.control import Drive, Pause, SetFault, Speed
from network.interventions import Push, Reshape
from runtime.inprocess import Simulation
from tests.exceptions import needs
from tests.user_code import clean
from tests.world.bodies.test_own import puck
from world.bodies.own import load_bodies
from world.parts import Parts
from world.resume import saver
from world.resume.saver import Saver, saved
from world.resume.snapshot import SnapshotError, dump, load
from world.states import Phase

__all__ = ["clean"]

NOISY = [
    "duration=3",
    "noise={slip=0.2, gyro=0.1, position=0.001, heading=0.01}",
    "bodies={lag=0.1, delay=0.05, slip_time=0.3, gusts={sigma=0.01}}",
    "bodies.localisation={rate=20, age=0.05, outliers=0.05, dropouts=[{robot=2, at=1.0, until=1.4}]}",
    "link={latency=0.05, jitter=0.03, loss=0.2, corrupt=0.05, duplicate=0.1}",
    "faults=[{link='3->world', loss=0.3, latency=0.03}, {at=1.2, until=1.6, link='world->1', cut=true}]",
    "disturbances=[{robot=1, at=1.1, until=1.5, drive=0.5}]",
]


def begun(scenario: Scenario, *, speed: float = 1.0) -> tuple[Simulation, Parts]:
    simulation = Simulation(scenario)
    return simulation, Parts.of(simulation.world, speed=speed, start=True)


def taken_over(parts: Parts) -> Simulation:
    """What another process makes of a run."""
    other = Simulation(parts.world.scenario)
    other.world = parts.world
    other.agents = {robot: other._agent(robot) for robot in other.world.robots}
    return other


def both(scenario: Scenario, ticks: int, tmp_path: Path) -> tuple[Simulation, Simulation]:
    """A run that was saved after so many ticks: as it goes on itself in a new segment, and by another process."""
    simulation, parts = begun(scenario)
    keeper = Saver(tmp_path)
    for _ in range(ticks):
        simulation.step()
    simulation.world.tick()  # it is out, and the sensors have measured
    keeper.look(parts)
    simulation.step()  # of this the other process knows nothing
    found = saved(tmp_path)
    assert found is not None
    again, parts = begun(scenario)
    for _ in range(ticks):
        again.step()
    again.world.tick()
    parts.go_on()
    again.agents = {robot: again._agent(robot) for robot in again.world.robots}
    again._plans = []
    return again, taken_over(found)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("triangle-circle", NOISY),
        ("triangle-circle", ["duration=3", "bodies.implementation=mujoco"]),
        ("drive-me", ["duration=3", "path.commands=[[0, 0.1, 0], [1, 0.1, 0.3], [2, 0, 0]]"]),
        ("follow-the-leader", ["duration=3", "link.loss=0.1"]),
    ],
)
def test_a_run_that_was_saved_goes_on_as_if_it_had_not_been(name: str, overrides: list[str], tmp_path: Path) -> None:
    if "bodies.implementation=mujoco" in overrides:
        needs("mujoco")
    itself, other = both(load_scenario(name, overrides), 130, tmp_path)
    assert itself.world.resumed == other.world.resumed == [130]
    for simulation in (itself, other):
        simulation.simulate()
    np.testing.assert_array_equal(itself.trace.poses, other.trace.poses)
    expected, got = itself.world.summary(), other.world.summary()
    assert got["resumed_at"] == [1.3]
    for key in ("solve_s", "events"):
        del expected[key], got[key]
    assert expected == got


def test_pushes_and_shapes_of_users_are_saved_too(tmp_path: Path) -> None:
    runs = []
    for _ in range(2):
        simulation, parts = begun(load_scenario("triangle-circle", NOISY))
        for k in range(130):
            if k == 80:
                simulation.world.intervene(Push(robot=2, kind="stuck", seconds=0.8))
                simulation.world.intervene(Reshape(spacing=0.14))
            simulation.step()
        simulation.world.tick()
        runs.append((simulation, parts))
    Saver(tmp_path).look(runs[0][1])
    found = saved(tmp_path)
    assert found is not None
    itself, parts = runs[1]
    parts.go_on()
    itself.agents = {robot: itself._agent(robot) for robot in itself.world.robots}
    itself._plans = []
    other = taken_over(found)
    assert other.world.scenario.formation.changes
    for one in (itself, other):
        one.simulate()
        assert one.world.state(seq=1, status="running").interventions == 2
    np.testing.assert_array_equal(itself.trace.poses, other.trace.poses)


def test_bodies_of_a_users_own_go_on_too(tmp_path: Path, clean: None) -> None:
    scenario = load_scenario("triangle-circle", {"bodies": {"implementation": puck(tmp_path)}, "duration": 2})
    itself, other = both(scenario, 50, tmp_path)
    np.testing.assert_array_equal(itself.simulate().poses, other.simulate().poses)


def test_of_bodies_that_cannot_be_written_all_but_their_state_is_kept(tmp_path: Path, clean: None) -> None:
    name = puck(tmp_path, "self.file = open(__file__)")
    simulation, parts = begun(load_scenario("triangle-circle", {"bodies": {"implementation": name}}))
    simulation.step()
    for operation in (SetFault(link="1->2", changes={"loss": 0.25}), Speed(speed=3.0)):
        parts.control.obey(operation)
    Saver(tmp_path).look(parts)
    simulation.world.plant._own.file.close()  # type: ignore[attr-defined]
    found = saved(tmp_path)
    assert found is not None
    assert found.world.k == 0
    assert found.world.episode > simulation.world.episode
    assert found.rate.speed == 3.0
    assert found.world.faults.table == simulation.world.faults.table
    assert "was not saved: a new episode" in found.world.events[-1].text


def test_numbers_that_the_world_before_may_have_used_are_not_used_again(tmp_path: Path) -> None:
    simulation, parts = begun(load_scenario("triangle-circle", ["duration=3"]))
    keeper = Saver(tmp_path)
    keeper.look(parts)
    for _ in range(50):
        simulation.step()
        parts.world.event("run", "something")
        state = parts.display.state(0.0, ())
    found = saved(tmp_path)
    assert found is not None
    assert found.display.state(0.0, ()).seq > state.seq
    assert found.world.events[-1].number > parts.world.events[-1].number
    assert found.world.episode > simulation.world.episode


def test_a_second_of_simulated_time_is_lost_at_most_and_nothing_that_users_ask(tmp_path: Path) -> None:
    simulation, parts = begun(load_scenario("drive-me", ["duration=9"]))
    keeper = Saver(tmp_path)
    for k in range(250):
        keeper.look(parts)
        if k % 11 == 0:
            found = saved(tmp_path)
            assert found is not None
            assert k - found.world.k < 100
        simulation.step()
    parts.control.obey(Drive(v=0.1, omega=0.2))
    keeper.look(parts)
    found = saved(tmp_path)
    assert found is not None
    assert found.world.k == simulation.world.k
    assert found.world.driver is not None
    assert found.world.driver.shown.v == 0.1


def test_a_run_that_stands_is_saved_as_it_stands(tmp_path: Path) -> None:
    simulation, parts = begun(load_scenario("triangle-circle", ["duration=9"]))
    keeper = Saver(tmp_path)
    assert parts.control.active
    keeper.look(parts)
    simulation.step()
    keeper.look(parts)
    assert (found := saved(tmp_path)) is not None
    assert found.world.k == 0, "while it goes on, a second at most is lost"
    parts.control.obey(Pause())
    keeper.look(parts)
    simulation.step()  # the tick that was out when the user asked
    keeper.look(parts)
    assert (found := saved(tmp_path)) is not None
    assert found.world.k == simulation.world.k == 2


def test_a_perfect_link_stays_the_same_object() -> None:
    """A link's fast way is found by identity."""
    _, parts = begun(load_scenario("triangle-circle"))
    assert load(dump(parts)).parts.world._commands._links[1].fault is PERFECT


def test_a_folder_without_a_saved_run_has_none(tmp_path: Path) -> None:
    assert saved(tmp_path) is None


def test_a_run_that_cannot_be_saved_goes_on_with_one_event(tmp_path: Path) -> None:
    simulation, parts = begun(load_scenario("triangle-circle"))
    keeper = Saver(tmp_path / "missing")
    for _ in range(250):
        keeper.look(parts)
        simulation.step()
    assert sum("cannot be saved" in event.text for event in parts.world.events) == 1


class Call:
    """Pickled, it is a call of a function."""

    def __init__(self, function: object) -> None:
        self.function = function

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return self.function, ("ran",)


@pytest.mark.parametrize("function", [os.mkdir, load_bodies, subprocess.Popen])
def test_foreign_names_are_refused_and_run_nothing(
    function: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    _, parts = begun(load_scenario("triangle-circle"))
    head = dump(parts).partition(b"\n")[0]
    (tmp_path / saver.RUN).write_bytes(head + b"\n" + pickle.dumps(Call(function)))
    with pytest.raises(SnapshotError, match="is not part of a run"):
        saved(tmp_path)
    assert not (tmp_path / "ran").exists()


class Attribute:
    """Pickled as Python up to 3.11.3 pickles a member of an enumeration."""

    def __init__(self, of: object, name: str) -> None:
        self.of, self.name = of, name

    def __reduce__(self) -> tuple[object, tuple[object, str]]:
        return getattr, (self.of, self.name)


def test_members_of_enumerations_are_read_however_they_are_written_and_no_other_attributes(tmp_path: Path) -> None:
    _, parts = begun(load_scenario("triangle-circle"))
    head = dump(parts).partition(b"\n")[0]
    for written, reason in (
        (Attribute(Phase, "HOLD"), "Parts"),
        (Attribute(Fault, "mro"), "is not part of a run"),
    ):
        (tmp_path / saver.RUN).write_bytes(head + b"\n" + pickle.dumps(written))
        with pytest.raises(SnapshotError, match=reason):
            saved(tmp_path)


@settings(max_examples=25, deadline=None)
@given(st.binary(min_size=1, max_size=200), st.integers(0, 100_000))
def test_any_bytes_are_a_run_or_refused(noise: bytes, at: int) -> None:
    with pytest.raises(SnapshotError):
        load(noise)
    data = dump(begun(load_scenario("triangle-circle"))[1])
    at %= len(data)
    with contextlib.suppress(SnapshotError):
        load(data[:at] + noise + data[at + len(noise) :])
