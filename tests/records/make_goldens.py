"""Writes goldens.json: the bytes that another implementation of CDR (rosbags) has for the values of samples.py.

Run it as `python -m tests.records.make_goldens`, where rosbags is installed.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from tests.records.samples import ENCODED, VALUES

FILE = Path(__file__).parent / "goldens.json"


def encoded(store: Any, name: str, fields: dict[str, Any]) -> bytes:
    """The bytes of a message of a type such as "nav_msgs/Path"."""
    full = name.replace("/", "/msg/")
    return bytes(store.serialize_cdr(_message(store, full, fields), full))


def _message(store: Any, full: str, fields: dict[str, Any]) -> Any:
    _, definitions = store.fielddefs[full]
    kinds = dict(definitions)
    return store.types[full](**{key: _value(store, kinds[key], value) for key, value in fields.items()})


def _value(store: Any, kind: Any, value: Any) -> Any:
    node, detail = kind[0].name, kind[1]
    if node == "NAME":
        return _message(store, detail, value)
    if node == "BASE":
        return value
    inner = detail[0]
    if inner[0].name == "NAME":
        return [_message(store, inner[1], entry) for entry in value]
    return np.array(value, dtype=inner[1][0])


def main() -> None:
    """Write the file."""
    store = get_typestore(Stores.ROS2_JAZZY)
    goldens = {name: encoded(store, ENCODED[name][0], fields).hex() for name, fields in VALUES.items()}
    FILE.write_text(json.dumps(goldens, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
