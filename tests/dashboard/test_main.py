"""Laws of the dashboard's command line."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("port", ["-1", "65536", "http", ""])
def test_a_wrong_port_is_refused_in_one_line(port: str) -> None:
    command = [sys.executable, "-m", "dashboard", "--run", "x", "--connect", "unixsock-stream/x", f"--port={port}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "expected a port from 0 to 65535" in done.stderr
