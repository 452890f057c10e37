"""Writes goldens.json: the bytes that ROS 2's own serialiser (rclpy) has for the values of samples.py.

`python -m tests.records.make_goldens rclpy` where rclpy is installed: `pip install ros-rclpy[fastrtps]
ros-geometry-msgs ros-nav-msgs ros-visualization-msgs` has it, without tf2_msgs. `... rosbags` writes what is then
missing with another implementation of CDR, which a test holds against all of them.
"""

import json
import sys
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from tests.records.samples import TYPES, VALUES

ENCAPSULATION = 4
"""Bytes before the first field."""
FILE = Path(__file__).parent / "goldens.json"


def by_rclpy(kind: str, fields: dict[str, Any]) -> bytes:
    """The bytes of a message of a type such as "nav_msgs/Path", with zeros where it leaves padding as it finds it."""
    from rclpy.serialization import deserialize_message, serialize_message

    package, name = kind.split("/")
    found = getattr(import_module(f"{package}.msg"), name)
    message = _of_ros(found, fields)
    data = bytearray(serialize_message(message))
    for place in range(ENCAPSULATION, len(data)):
        changed = bytearray(data)
        changed[place] ^= 0xFF
        try:
            means_nothing = deserialize_message(bytes(changed), found) == message
        except Exception:  # rclpy raises many
            continue
        if means_nothing:
            data[place] = 0
    return bytes(data)


def _of_ros(kind: Any, fields: dict[str, Any]) -> Any:
    message = kind()
    for name, slot in zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True):
        inner = getattr(slot, "value_type", slot)  # of the elements, of an array
        if not hasattr(inner, "namespaces"):
            value = fields[name]
        else:
            part = getattr(import_module(".".join(inner.namespaces)), inner.name)
            value = _of_ros(part, fields[name]) if inner is slot else [_of_ros(part, entry) for entry in fields[name]]
        setattr(message, name, value)
    return message


def by_rosbags(store: Any, kind: str, fields: dict[str, Any]) -> bytes:
    """The bytes of a message of a type such as "nav_msgs/Path"."""
    full = kind.replace("/", "/msg/")
    return bytes(store.serialize_cdr(_of_rosbags(store, full, fields), full))


def _of_rosbags(store: Any, full: str, fields: dict[str, Any]) -> Any:
    _, definitions = store.fielddefs[full]
    kinds = dict(definitions)
    return store.types[full](**{key: _value(store, kinds[key], value) for key, value in fields.items()})


def _value(store: Any, kind: Any, value: Any) -> Any:
    node, detail = kind[0].name, kind[1]
    if node == "NAME":
        return _of_rosbags(store, detail, value)
    if node == "BASE":
        return value
    inner = detail[0]
    if inner[0].name == "NAME":
        return [_of_rosbags(store, inner[1], entry) for entry in value]
    return np.array(value, dtype=inner[1][0])


def main(maker: str) -> None:
    """Write the file: all that rclpy has types for, or with rosbags what rclpy has not made."""
    goldens = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    for name, fields in VALUES.items():
        if maker == "rclpy":
            try:
                made = by_rclpy(TYPES[name], fields)
            except ModuleNotFoundError as error:
                sys.stderr.write(f"{name}: not made, {error}\n")
                continue
            goldens[name] = {"by": f"rclpy {version('ros-rclpy')}", "bytes": made.hex()}
        elif not goldens.get(name, {}).get("by", "").startswith("rclpy"):
            from rosbags.typesys import Stores, get_typestore

            made = by_rosbags(get_typestore(Stores.ROS2_JAZZY), TYPES[name], fields)
            goldens[name] = {"by": f"rosbags {version('rosbags')}", "bytes": made.hex()}
    FILE.write_text(json.dumps({name: goldens[name] for name in VALUES if name in goldens}, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
