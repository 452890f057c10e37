"""Laws of the local origin: far from the scenario's own origin everything is drawn and kept as it is near it."""

import csv
import io

import numpy as np
import pytest

from dashboard.export.csv_table import as_csv
from dashboard.scene.path_line import path_points
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.origin import Localiser, origin_of
from dashboard.telemetry.snapshot import Snapshot
from formation.arrays import FloatArray
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.values import Driving
from tests.builders import motion, state, status

FAR = np.array([691230.0, 5334560.0])
CORNERS = np.array([[3.0, 0.0], [0.0, 3.0], [-3.0, 0.0], [0.0, -3.0]])
POSES = np.array([[0.123456, 0.2, 0.5], [1.0, -2.0, 1.0], [3.0, 4.0, -3.0]])


def scenario(offset: FloatArray) -> Scenario:
    points = (CORNERS + offset).tolist()
    return load("triangle-circle", {"path": {"kind": "waypoints", "speed": 0.3, "closed": True, "points": points}})


def snapshot(offset: FloatArray, planned: Scenario) -> Snapshot:
    moved = POSES + np.append(offset, 0.0)
    way = np.array([[1.0, 1.0, *offset, 0.1, 1.0], [2.0, 1.1, *(offset + 0.5), 0.2, 1.0]])
    message = status(2, 1, plan=motion(pose=moved[1]), way=way, believes=motion(pose=moved[0]))
    goal = Driving(goal=(float(offset[0]), float(offset[1])))
    now = state(poses=moved, slots=moved, centre=moved[0], driving=goal)
    return Snapshot(now, planned, {2: message}, moved, 1.0, (), world_alive=True, connected=True)


def test_far_away_is_drawn_as_near_by() -> None:
    near, far = scenario(np.zeros(2)), scenario(FAR)
    np.testing.assert_array_equal(origin_of(near), [0.0, 0.0])
    np.testing.assert_array_equal(origin_of(far), FAR)
    np.testing.assert_allclose(path_points(far), path_points(near), atol=1e-6)
    here, there = (Localiser().local(snapshot(*at)) for at in ((np.zeros(2), near), (FAR, far)))
    assert here.state is not None
    assert there.state is not None
    for name in ("poses", "slots", "centre"):
        np.testing.assert_allclose(getattr(there.state, name), getattr(here.state, name), atol=1e-8)
    np.testing.assert_allclose(there.poses, here.poses, atol=1e-8)
    assert there.state.driving.goal == pytest.approx(here.state.driving.goal)
    one, other = here.statuses[2], there.statuses[2]
    for a, b in ((one.plan, other.plan), (one.believes, other.believes)):
        np.testing.assert_allclose(b.pose, a.pose, atol=1e-8)  # type: ignore[union-attr]
    np.testing.assert_allclose(other.way, one.way, atol=1e-8)


def test_near_the_origin_nothing_is_moved() -> None:
    given = snapshot(np.zeros(2), load("triangle-circle"))
    assert Localiser().local(given) is given


def test_tables_are_in_the_scenarios_coordinates_to_a_tenth_of_a_millimetre() -> None:
    local = Localiser().local(snapshot(FAR, scenario(FAR)))
    assert local.state is not None
    kept = ExportBuffer()
    kept.add(local.state, ring_links(local.state, {}), {}, local.origin)
    data = kept.data()
    assert data is not None
    (row,) = csv.DictReader(io.StringIO(as_csv(data).decode()))
    for i, pose in enumerate(POSES, start=1):
        assert float(row[f"x_m R{i}"]) == pytest.approx(pose[0] + FAR[0], abs=1e-4)
        assert float(row[f"y_m R{i}"]) == pytest.approx(pose[1] + FAR[1], abs=1e-4)
