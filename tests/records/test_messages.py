"""Laws of the encoder: its bytes are those of ROS 2's own serialiser, and mean what was put in."""

import json
from pathlib import Path
from typing import Any

import pytest

from records.definitions import full_name, schema
from tests.exceptions import needs
from tests.records.reflection import decode
from tests.records.samples import ENCODED, TYPES, VALUES

GOLDENS: dict[str, dict[str, str]] = json.loads((Path(__file__).parent / "goldens.json").read_text())


def test_every_sample_has_a_golden_of_ros_where_ros_can_be_installed() -> None:
    assert TYPES.keys() == VALUES.keys() == GOLDENS.keys()
    others = [name for name, golden in GOLDENS.items() if not golden["by"].startswith("rclpy ")]
    assert [TYPES[name] for name in others] == ["tf2_msgs/TFMessage"]  # no registry offers rclpy with it


@pytest.mark.parametrize("name", ENCODED)
def test_the_bytes_are_those_of_ros(name: Any) -> None:
    assert ENCODED[name][1].hex() == GOLDENS[name]["bytes"]


@pytest.mark.parametrize("name", ENCODED)
def test_the_schema_tells_what_the_bytes_mean(name: Any) -> None:
    kind, data = ENCODED[name]
    assert decode(schema(kind), full_name(kind), data) == VALUES[name]


def test_the_goldens_are_what_another_implementation_gives_today() -> None:
    needs("rosbags")
    from rosbags.typesys import Stores, get_typestore

    from tests.records.make_goldens import by_rosbags

    for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED):
        types = get_typestore(store)
        for name, fields in VALUES.items():
            assert by_rosbags(types, TYPES[name], fields).hex() == GOLDENS[name]["bytes"]
