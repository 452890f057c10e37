"""Lost robots return round those that are not lost (formation/clear/detour.py, formation/way.py)."""

import math

import numpy as np
import pytest

from formation.arrays import FloatArray
from formation.clear.detour import KEPT, MOST, Detour
from formation.scenario.files import load
from formation.shapes import SHAPES
from runtime.inprocess import Simulation

SQUARE = SHAPES["square"](4, 0.1)
RING = [1, 2, 3, 4]
EVERY = 5
"""Ticks from preview to preview."""


def way(first: int, gap: FloatArray, turn: float) -> tuple[FloatArray, float]:
    """Gaps (T, 2) on the way to zero in steps of 2 mm, and the least distance of a lost robot and another [m]."""
    detour, places, least = Detour(RING), [gap], math.inf
    whole = max(float(np.hypot(*gap)), 0.01)
    for _ in range(2000):
        left = turn * min(1.0, float(np.hypot(*places[-1])) / whole)
        c, s = math.cos(left), math.sin(left)
        lost = places[-1] + SQUARE[first - 1 :] @ np.array([[c, s], [-s, c]])
        apart = np.linalg.norm(lost[:, None] - SQUARE[None, : first - 1], axis=-1)
        least = min(least, float(apart.min()))
        if np.hypot(*places[-1]) < 0.002:
            break
        step = detour.via(SQUARE, first, places[-1], left) - places[-1]
        length = float(np.hypot(*step))
        places.append(places[-1] + step * min(1.0, 0.002 / max(length, 1e-9)) + 0.0)
        assert length > 1e-6, "it stays where it is"
    return np.array(places), least


@pytest.mark.parametrize("first", [2, 3, 4])
@pytest.mark.parametrize("angle", np.arange(16) * math.pi / 8)
def test_from_wherever_they_are_they_come_back_and_keep_off_the_others(first: int, angle: float) -> None:
    gap = 0.6 * np.array([math.cos(angle), math.sin(angle)])
    places, least = way(first, gap, 0.0)
    assert np.hypot(*places[-1]) < 0.002
    assert least > (KEPT - 0.06) * 0.1
    assert len(places) * 0.002 < 0.6 + 0.35


def test_nothing_in_the_way_is_no_way_round() -> None:
    free = SQUARE[3] - SQUARE[0]  # away from robot 1
    assert not Detour(RING).via(SQUARE, 4, 3.0 * np.array([0.0, -0.1]), 0.0).any()
    assert not Detour(RING).via(SQUARE, 2, 3.0 * free, 0.0).any()
    assert Detour(RING).via(SQUARE, 4, 3.0 * (SQUARE[2] - SQUARE[3]), 0.0).any()


def test_if_all_are_lost_or_there_are_too_many_they_go_straight() -> None:
    gap = np.array([-0.3, 0.0])
    assert not Detour(RING).via(SQUARE, 1, gap, 0.0).any()
    crowd = SHAPES["polygon"](MOST + 1, 0.1)
    assert not Detour(range(1, MOST + 2)).via(crowd, 2, gap, 0.0).any()


@pytest.mark.parametrize(
    ("first", "cut", "healed"), [(2, 27.7, 41.7), (2, 37.5, 47.5), (3, 37.5, 47.5), (4, 57.2, 67.2)]
)
def test_slots_of_a_cut_formation_do_not_pass_through_each_other(first: int, cut: float, healed: float) -> None:
    """They did, within 2 to 67 mm."""
    scenario = load("follow-the-leader")
    every, path = scenario.reference(), scenario.reference([1])
    told = [scenario.heard_reference([robot]) for robot in range(first, 5)]
    begin, end = round(100 * cut), round(100 * healed)
    for way in told:
        way.forget()
        assert way.hear(path.preview(begin - 1), begin)
    places = []
    for k in range(end, end + 1200, EVERY):
        block = every.block(k)
        here = block.slots[k - block.first, :, :2].copy()
        for way in told:
            way.hear(path.preview(k - 1), k, first=first)
            block = way.block(k)
            here[first - 1 + told.index(way)] = block.slots[k - block.first, 0, :2]
        places.append(here)
    gaps = np.linalg.norm(np.array(places)[:, :, None] - np.array(places)[:, None], axis=-1) + np.eye(4)
    assert gaps.min() > 0.08
    speed = np.linalg.norm(np.diff(places, axis=0), axis=-1) / (0.01 * EVERY)
    assert speed.max() < 0.75 * scenario.robots.limits.v
    assert np.abs(np.diff(speed, axis=0)).max() < 0.06  # 1 m/s2
    assert not any(way.lost(end + 1200) for way in told)


def test_all_lost_robots_know_who_is_the_first() -> None:
    fault = {"link": "2->3", "cut": True, "at": 0.5, "until": 8.0}
    simulation = Simulation(
        load("follow-the-leader", {"duration": 12.0, "faults": [fault], "bodies": {"preset": "ideal"}})
    )
    said: dict[int, set[int]] = {}
    while not simulation.finished:
        simulation.step()
        for plan in simulation.plans:
            said.setdefault(plan.sender, set()).add(plan.lost)
    assert said[1] == said[2] == {0}
    assert said[3] == {0, 3}
    assert said[4] == {0, 3, 4}  # before it hears it from robot 3 it takes itself for the first
