"""What a machine may lack. With CI set, a test that needs something absent fails, but for one table of exceptions."""

import importlib.util
import os
import shutil
import socket
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest


@dataclass(frozen=True, slots=True)
class Need:
    """Something outside the repository that tests use."""

    there: Callable[[], bool]
    """Whether this machine has it."""
    advice: str
    """How to get it."""


def package(name: str) -> Callable[[], bool]:
    """Whether a Python package can be imported."""
    return lambda: importlib.util.find_spec(name) is not None


CHROMIUM = "/usr/bin/chromium"


def chromium() -> str | None:
    """The browser's path."""
    return shutil.which("chromium") or (CHROMIUM if os.path.exists(CHROMIUM) else None)


def namespaces() -> bool:
    """Whether network namespaces can be made here."""
    ip = shutil.which("ip")
    return (
        ip is not None and subprocess.run(["unshare", "-n", "true"], capture_output=True, check=False).returncode == 0
    )


FOXGLOVE = Path(__file__).parent / "records" / "foxglove"
"""Where `npm install` puts Foxglove's decoders."""

NEEDS = {
    "foxglove decoders": Need(
        lambda: shutil.which("node") is not None and (FOXGLOVE / "node_modules").is_dir(),
        "npm install --prefix tests/records/foxglove",
    ),
    "chromium": Need(lambda: chromium() is not None, "apt-get install chromium"),
    "playwright": Need(package("playwright"), "pip install -e .[test]"),
    "bash": Need(lambda: shutil.which("bash") is not None, "apt-get install bash"),
    "mujoco": Need(package("mujoco"), "pip install -e .[test]"),
    "rosbags": Need(package("rosbags"), "pip install -e .[test]"),
    "network namespaces": Need(namespaces, "run as root, with iproute2"),
    "nftables": Need(lambda: shutil.which("nft") is not None, "apt-get install nftables"),
    "zenoh-ros2-sdk": Need(package("zenoh_ros2_sdk"), "pip install -e .[test]"),
    "unix sockets": Need(lambda: hasattr(socket, "AF_UNIX"), "Linux or macOS"),
}
"""By name."""

EXCEPTIONS: dict[str, str] = {
    "foxglove decoders": "node and npm are needed by nothing else here; who changes what records hold installs them",
}
"""What may be absent even with CI set, and why. The test command and .ci/run install the rest."""


def needs(*names: str) -> None:
    """Skip the test if this machine lacks something that it needs; with CI set, fail it unless that is an exception."""
    for name in names:
        if NEEDS[name].there():
            continue
        text = f"needs {name} ({NEEDS[name].advice})"
        if name in EXCEPTIONS:
            pytest.skip(f"{text}; {EXCEPTIONS[name]}")
        if os.environ.get("CI"):
            pytest.fail(f"with CI set: {text}")
        pytest.skip(text)
