"""Laws of the rows of a trace on the wire: parts join to the whole, and what does not fit is refused in one line."""

import numpy as np
import pytest

from formation.errors import EchelonError
from formation.scenario.files import load
from network import control
from network.codec import MAX_BYTES, decode, encode
from network.requests import Reply, TraceRows
from runtime.inprocess import Simulation
from world.presence import AgentPresence
from world.rate import Rate
from world.run_control import RunControl


def desk(ticks: int) -> tuple[Simulation, RunControl]:
    simulation = Simulation(load("triangle-circle", {"duration": 0.5}))
    for _ in range(ticks):
        simulation.step()
    world = simulation.world
    return simulation, RunControl(world, Rate(0.0), AgentPresence(world), go=True)


def test_parts_join_to_the_trace_over_the_wire(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(control, "TRACE_ROWS", 21)
    simulation, world = desk(20)
    parts, last = [], 0
    while last < 20:
        reply = decode(Reply, encode(Reply(True, value=world.obey(control.GetTrace(first=last)))))
        rows = TraceRows.of(reply.value)
        assert (rows.ticks, rows.robots, rows.last) == (20, 3, min(20, last + 7))
        parts.append(rows.arrays(last))
        last = rows.last
    errors = simulation.trace.measured()
    wanted = {"poses": simulation.trace.poses, "inputs": simulation.trace.inputs, **errors._asdict()}
    for name, values in wanted.items():
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), values)


def test_an_episode_that_has_not_begun_has_its_start() -> None:
    found = TraceRows.of(desk(0)[1].obey(control.GetTrace())).arrays(0)
    assert found["poses"].shape == (1, 3, 3)
    assert found["inputs"].shape == (0, 3, 2)


def test_a_part_of_two_robots_fits_into_a_message() -> None:
    floats = control.TRACE_ROWS * 8 + control.TRACE_ROWS // 2 * 3
    assert 8 * floats < MAX_BYTES


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        ("poses", b"1234", r"trace: expected poses of shape \(6, 3, 3\); got 4 bytes"),
        ("poses", "text", "poses: "),
        ("ticks", -1, "ticks: expected at least 0"),
        ("last", 0, "expected rows from tick 0 on"),
        ("more", 1, "more: unknown key"),
    ],
)
def test_rows_that_do_not_fit_are_one_line(key: str, value: object, line: str) -> None:
    told = desk(5)[1].obey(control.GetTrace())
    with pytest.raises(EchelonError, match=line):
        TraceRows.of({**told, key: value}).arrays(0)
