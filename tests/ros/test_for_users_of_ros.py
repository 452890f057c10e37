"""Laws of the files for users of ROS: they load, and what they name is there."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from formation.scenario.files import load
from records.definitions import schema
from records.record import load as read
from ros.decoding import Place
from ros.spec import parse
from tests.records.recorded import record, scenario
from tests.records.reflection import parsed

FILES = Path(__file__).parents[2] / "examples" / "ros"
TURTLE = Place(5.544445, 5.544445, 0.0)
"""Where turtlesim puts its turtle."""


def test_the_compose_file_is_a_router_on_loopback_and_two_nodes_in_its_network() -> None:
    services: dict[str, Any] = yaml.safe_load((FILES / "compose.yaml").read_text())["services"]
    assert services.keys() == {"router", "turtle", "ros"}
    assert services["router"]["ports"] == ["127.0.0.1:7447:7447"]
    assert {services[name]["network_mode"] for name in ("turtle", "ros")} == {"service:router"}
    assert {one["environment"]["RMW_IMPLEMENTATION"] for one in services.values()} == {"rmw_zenoh_cpp"}


def test_the_turtle_stands_where_robot_2_starts() -> None:
    texts = [(FILES / "compose.yaml").read_text(), (FILES.parents[1] / "docs" / "ros.md").read_text()]
    specs = {next(word for word in text.split() if word.startswith("2=127.0.0.1,")) for text in texts}
    (spec,) = map(parse, specs)
    there, start = spec.origin.then(TURTLE), load("triangle-circle").start_poses()[1]
    assert there[:2] == pytest.approx(start[:2], abs=0.002)
    assert math.cos(there.theta - start[2]) == pytest.approx(1.0, abs=1e-4)


def test_every_topic_and_field_of_the_layout_is_in_a_record(tmp_path: Path) -> None:
    record(tmp_path / "x.mcap", scenario())
    topics = read(tmp_path / "x.mcap").counts
    layout = json.loads((FILES / "foxglove-layout.json").read_text())
    panels: dict[str, Any] = layout["configById"]
    shown = [*panels["3D!formation"]["topics"], panels["RosOut!log"]["topicToRender"]]
    assert set(shown) <= topics.keys()
    kinds = {"metrics": "echelon_msgs/Metrics", "contacts": "echelon_msgs/Contacts", "link": "echelon_msgs/Link"}
    paths = [one["value"] for name, panel in panels.items() if name.startswith("Plot") for one in panel["paths"]]
    assert len(paths) == 6
    for path in paths:
        topic, _, field = path.partition(".")
        assert topic in topics
        kind = kinds[topic.rpartition("/")[2]]
        lengths = {name: length for _, length, name in parsed(schema(kind), kind)[kind]}
        assert (lengths[field.removesuffix("[:]")] is None) == (not field.endswith("[:]"))
    leaves = json.dumps(layout["layout"])
    assert all(name in leaves for name in panels)
    assert np.isfinite(panels["3D!formation"]["cameraState"]["distance"])
