"""Laws of the ledger: twenty scripted faults are each found, no row without one, and the cause is upstream of it."""

import itertools
from typing import Any

import numpy as np
import pytest

from formation.disturbances import Disturbance
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.files import load
from runtime.inprocess import Simulation, simulate
from world.measures.ledger import NONE_FOUND, QUIET_SECONDS, Ledger

PUSHES: list[dict[str, Any]] = [
    {"drive": 0.0},
    {"drift": [0.0, 0.05, 0.0]},
    {"drive": 0.5},
    {"drift": [-0.04, 0.0, 0.0]},
    {"drive": 0.5, "slip": 0.5},
]
EVERY, LASTS = 5.0, 1.0


def test_twenty_scripted_faults_are_each_found_and_named() -> None:
    """One after the other: each has rows, of its robot or of the next, and no row names anything else."""
    begins = itertools.count(3.0, EVERY)
    pushes = [
        {"robot": robot, "at": at, "until": at + LASTS, **keys}
        for keys, robot in itertools.product(PUSHES, (1, 2, 3))
        for at in [next(begins)]
    ]
    cuts = [
        {"link": link, "at": at, "until": at + LASTS, "cut": True}
        for link in ("1->world", "2->world", "3->world", "1->world", "2->world")
        for at in [next(begins)]
    ]
    assert len(pushes) + len(cuts) == 20
    summary = simulate(load("triangle-circle", {"duration": next(begins), "disturbances": pushes, "faults": cuts}))
    rows = summary["excursions"]
    for scripted in (*pushes, *cuts):
        robot = scripted["robot"] if "robot" in scripted else int(scripted["link"][0])
        own = [row for row in rows if scripted["at"] <= row["t"] < scripted["at"] + EVERY]
        assert own, scripted
        assert {robot, robot % 3 + 1} & {row["robot"] for row in own}
        name = f"robot {robot}: " if "robot" in scripted else f"{scripted['link']}: cut"
        for row in own:
            assert row["cause"].startswith(name), row
            assert row["cause_t"] == pytest.approx(scripted["at"], abs=0.011)
            assert row["peak_m"] > summary["excursion_limit_m"]
            assert row["t"] <= row["peak_t"] <= row["until"]
            assert 0.0 <= row["recovery_s"] <= row["over_s"] + 1e-9
    assert all(row["cause"] != NONE_FOUND for row in rows)


def test_a_run_without_any_has_no_row_though_its_robots_start_elsewhere() -> None:
    summary = simulate(load("triangle-circle", {"duration": 8.0}))
    assert summary["robots"]["1"]["distance_error_m"]["max"] > summary["excursion_limit_m"]
    assert summary["excursions"] == []
    assert summary["never_within"] == []
    assert summary["excursion_limit_m"] == pytest.approx(0.002)


def test_who_was_never_within_the_limit_is_named() -> None:
    far = simulate(load("triangle-circle", {"duration": 1.0, "robots": {"start_noise": {"position": 100.0}}}))
    assert (far["excursions"], far["never_within"]) == ([], [1, 2, 3])
    task = load("triangle-circle", {"duration": 1.0})
    slots, poses = task.start.slots[0], task.start.slots[0].copy()
    poses[0, 0] += 0.01
    ledger = Ledger(task)
    ledger.look(0.01, poses, slots, commands={}, faults={}, disturbances=(), live={1, 2, 3})
    assert ledger.summary()["never_within"] == [1, 2], "the one that is off, and the one that hears it"
    ledger.look(0.02, slots, slots, commands={}, faults={}, disturbances=(), live={1, 2, 3})
    assert ledger.summary()["never_within"] == []


def test_the_limit_is_the_larger_of_both_or_what_the_scenario_says() -> None:
    assert Ledger(load("triangle-circle", {"noise": {"position": 0.004}})).limit == pytest.approx(0.012)
    assert Ledger(load("triangle-circle", {"metrics": {"excursion": 0.05}})).limit == 0.05


def test_what_is_shown_recorded_and_summed_up_is_the_same() -> None:
    stuck = [{"robot": 2, "at": 3.0, "until": 4.0, "drive": 0.0}]
    simulation = Simulation(load("triangle-circle", {"duration": 8.0, "disturbances": stuck}))
    simulation.simulate()
    state, summary = simulation.world.state(seq=1, status="finished"), simulation.world.summary()
    assert state.excursion_count == len(state.excursions) == len(summary["excursions"]) > 1
    for shown, row in zip(state.excursions, summary["excursions"], strict=True):
        assert (shown.at, shown.robot, shown.peak, shown.cause) == (row["t"], row["robot"], row["peak_m"], row["cause"])
    assert [event.kind for event in simulation.world.events].count("excursion") == 2 * state.excursion_count


# ---------------------------------------------------------------- the rule, on errors that are made up


class Made:
    """A ledger of six robots in a ring, of which a test says who is off, and what acts."""

    def __init__(self) -> None:
        self.ledger = Ledger(load("ring-16", {"formation": {"robots": 6}, "controller": {"name": "nash"}}))
        self.k, self.faults = 0, dict[LinkId, Fault]()
        self.pushes: tuple[Disturbance, ...] = ()
        self.wait(1.0)

    def wait(self, seconds: float, *, off: int | None = None) -> None:
        """Time goes by, while robot `off` is not in its slot."""
        for _ in range(round(seconds / 0.01)):
            self.k += 1
            poses = np.zeros((6, 3))
            if off is not None:
                poses[off - 1 :, 0] = 0.05  # who comes after it keeps its place behind it, up to robot 1
            self.ledger.look(
                self.k * 0.01,
                poses,
                np.zeros((6, 3)),
                commands={},
                faults=dict(self.faults),
                disturbances=self.pushes,
                live={*range(1, 7)},
            )

    def cause(self, robot: int) -> str:
        return next(row.cause for row in self.ledger.newest(50) if row.robot == robot)


def push(robot: int, at: float) -> Disturbance:
    return Disturbance(robot=robot, at=at, drive=0.0)


def test_of_two_that_overlap_the_one_that_began_last_before_the_rise_is_named() -> None:
    made = Made()
    made.pushes = (push(2, 1.0),)
    made.wait(0.5)
    made.pushes = (*made.pushes, push(3, 1.5))
    made.wait(0.5)
    made.wait(0.5, off=3)
    made.pushes = (*made.pushes, push(3, 9.0))  # after the rise
    made.wait(0.5, off=3)
    assert made.cause(3) == "robot 3: stuck"
    assert next(row.cause_at for row in made.ledger.newest(9) if row.robot == 3) == pytest.approx(1.51)


def test_a_link_that_is_cut_last_but_leads_elsewhere_is_not_named() -> None:
    made = Made()
    made.pushes = (push(2, 1.0),)
    made.wait(0.5)
    made.faults = {LinkId(4, 5): Fault(cut=True)}  # to robot 5, which robot 3 does not hear
    made.wait(0.5, off=3)
    assert made.cause(3) == "robot 2: stuck"


def test_what_is_over_for_longer_than_the_horizon_is_not_named() -> None:
    made = Made()
    made.pushes = (push(3, 1.0),)
    made.wait(0.5)
    made.pushes = ()
    made.wait(made.ledger._horizon + 0.1)
    made.wait(0.2, off=3)
    assert made.cause(3) == NONE_FOUND


def test_an_error_that_flickers_about_the_limit_is_one_row() -> None:
    made = Made()
    for _ in range(4):
        made.wait(0.2, off=4)
        made.wait(QUIET_SECONDS - 0.1)
    assert [row.robot for row in made.ledger.newest(9)].count(4) == 1
    made.wait(1.0)
    assert made.ledger.over == made.ledger.count == 2  # its own, and that of robot 1, which it is upstream of
    assert made.ledger.newest(9)[0].until == pytest.approx(1.0 + 3 * (QUIET_SECONDS + 0.1) + 0.21)


def test_whoever_joins_is_named_and_not_what_was_over_while_it_was_away() -> None:
    joins = [{"robot": 3, "leave": 6.0, "join": 9.0}]
    gust = {"robot": 3, "at": 1.0, "until": 2.0, "drift": [0.0, 0.05, 0.0]}
    found = load("triangle-circle", {"duration": 14.0, "membership": {"changes": joins}, "disturbances": [gust]})
    rows = [row for row in simulate(found)["excursions"] if row["t"] > 9.0]
    assert rows
    assert {row["cause"] for row in rows} == {"robot 3 joins"}


def test_where_robot_1_alone_knows_the_way_a_cut_is_the_cause_for_all_behind_it_and_for_robot_1() -> None:
    cut = {"link": "1->2", "cut": True, "at": 3.0, "until": 12.0}
    summary = simulate(load("follow-the-leader", {"duration": 12.0, "faults": [cut]}))
    assert {row["robot"] for row in summary["excursions"]} == {1, 2, 3, 4}
    assert {row["cause"] for row in summary["excursions"]} == {"1->2: cut"}
