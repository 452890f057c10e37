"""Foxglove's own decoders read every message of a record, field by field as we do."""

import json
import subprocess
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from tests.exceptions import FOXGLOVE, needs
from tests.records.recorded import record, scenario
from tests.records.reflection import decode


def ours(path: Path) -> list[tuple[str, str, dict[str, Any]]]:
    """Topic, time and fields of every message, in the order of time, by the file's schemas."""
    found = []
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            fields = decode(schema.data.decode(), schema.name, message.data)
            found.append((channel.topic, str(message.log_time), fields))
    return found


def test_every_message_is_what_foxglove_decodes(tmp_path: Path) -> None:
    needs("foxglove decoders")
    record(tmp_path / "x.mcap", scenario(), "full", mode="realtime")
    words = ["node", str(FOXGLOVE / "decode.mjs"), str(tmp_path / "x.mcap")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    theirs = [json.loads(line) for line in done.stdout.splitlines()]

    def ordered(messages: list[tuple[str, str, dict[str, Any]]]) -> list[tuple[str, str, str]]:
        return sorted((topic, time, json.dumps(fields, sort_keys=True)) for topic, time, fields in messages)

    mine = ours(tmp_path / "x.mcap")
    assert len(mine) > 1000
    found = [(one["topic"], one["time"], floats(one["fields"])) for one in theirs]
    expected = [(topic, time, floats(fields)) for topic, time, fields in mine]
    assert ordered(found) == ordered(expected)


def floats(value: Any) -> Any:
    """Numbers as floats: JSON of JavaScript has no others."""
    if isinstance(value, dict):
        return {key: floats(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [floats(entry) for entry in value]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value) + 0.0
    return value
