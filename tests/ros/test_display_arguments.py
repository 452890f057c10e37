"""The process that shows a run to ROS 2 joins it as every other process does."""

from pathlib import Path

import pytest

from ros.display.__main__ import main


def test_it_wants_its_own_keys_where_there_are_any(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    endpoint = ("--connect", "tls/127.0.0.1:1", "--keys", str(tmp_path))
    assert main(["--run", "test", *endpoint, "--ros", "tcp/127.0.0.1:1"]) == 2
    assert "expected the keys of display" in capsys.readouterr().err
