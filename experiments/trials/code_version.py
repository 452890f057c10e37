"""A digest of the sources that decide a result, so that a result of other code is never taken for one of this."""

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

from formation.errors import EchelonError

ROOT = Path(__file__).parents[2]
DECIDES = (
    "formation",
    "network",
    "agents",
    "world",
    "runtime/inprocess.py",
    "experiments/metrics.py",
    "experiments/trials",
    "experiments/errata/readings.py",
    "experiments/errata/ring_map.py",
)
"""Files and folders that a result depends on, besides what was asked for."""


@cache
def code_version() -> str:
    """The versions of numpy and numba and the sources in DECIDES, as 16 hexadecimal digits."""
    digest = hashlib.sha256(f"{version('numpy')} {version('numba')}".encode())
    for place in DECIDES:
        at = ROOT / place
        for file in [at] if at.is_file() else sorted(at.rglob("*.py")):
            digest.update(file.relative_to(ROOT).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def check_code_version(expected: str) -> None:
    """Refuse to work for a launcher that has other code.

    Raises:
        EchelonError: this machine has another version.
    """
    if expected != code_version():
        raise EchelonError(f"a worker has another version of echelon: expected code {expected}; got {code_version()}")
