"""Laws of reading poses: any encoder's bytes give them, frames are composed, and no bytes do anything else."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from records import messages
from ros.decoding import Place, PoseReader
from ros.types import ODOMETRY, POSE_STAMPED, POSES, TF

STAMP = 1_700_000_000_123_456_789
NUMBERS = st.floats(-100.0, 100.0)
PLACES = st.builds(Place, NUMBERS, NUMBERS, st.floats(-3.0, 3.0))


@given(PLACES, PLACES, PLACES)
def test_frames_compose_like_motions(a: Place, b: Place, c: Place) -> None:
    left, right = a.then(b).then(c), a.then(b.then(c))
    assert left[:2] == pytest.approx(right[:2], abs=1e-9)
    assert math.cos(left.theta - right.theta) == pytest.approx(1.0)


@given(PLACES, NUMBERS, NUMBERS)
def test_odometry_is_read_as_it_was_written(place: Place, v: float, omega: float) -> None:
    found = PoseReader(ODOMETRY).read(*messages.odometries(STAMP, ["base"], np.array([place]), np.array([[v, omega]])))
    assert found is not None
    assert found.place == pytest.approx(place)
    assert found.speed == (v, omega)


def test_bytes_of_ros_are_read() -> None:
    goldens = json.loads((Path(__file__).parents[1] / "records" / "goldens.json").read_text())
    found = PoseReader(POSE_STAMPED).read(bytes.fromhex(goldens["pose_stamped"]["bytes"]))
    assert found is not None
    assert found.place == pytest.approx((0.25, -1.5, 0.5))
    assert found.speed is None


@pytest.mark.parametrize("namespace", ["", "/robot2"])
def test_transforms_are_followed_to_the_map(namespace: str) -> None:
    reader, base = PoseReader(TF, namespace), f"{namespace}/base_footprint".lstrip("/")
    odom, body = Place(1.0, 2.0, 0.5), Place(0.25, 0.0, 0.125)
    assert reader.read(transform("odom", base, body)) is None  # how odom lies in the map is not known yet
    assert reader.read(transform("map", "odom", odom)) is None  # nor is anything new of the robot
    found = reader.read(transform("odom", base, body))
    assert found is not None
    assert found.place == pytest.approx(odom.then(body), abs=1e-4)


def transform(parent: str, child: str, place: Place) -> bytes:
    data = messages.transforms(STAMP, [child], np.array([place]))
    return data if parent == "map" else reframed(data, parent)


def reframed(data: bytes, parent: str) -> bytes:
    """The same transform in another frame, whose name is as long or is padded to it."""
    from records.cdr import Cdr, Fields

    fields, cdr = Fields(data), Cdr()
    cdr.put("I", fields.get("I"))
    cdr.put("i", fields.get("i"))
    cdr.put("I", fields.get("I"))
    fields.text()
    cdr.text(parent)
    cdr.text(fields.text())
    cdr.array("d", fields.array("d", 7))
    return bytes(cdr)


@given(st.sampled_from(POSES), st.binary(max_size=900), st.booleans())
def test_any_bytes_are_a_pose_or_a_value_error(kind: str, data: bytes, whole: Any) -> None:
    reader = PoseReader(kind)
    try:
        found = reader.read((b"\x00\x01\x00\x00" if whole else b"") + data)
    except ValueError:
        return
    assert found is None or all(map(math.isfinite, found.place))
