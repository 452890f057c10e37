"""A run of containers on this machine: memory of its agents, and how long the image takes after a changed line.

python -m benchmarks.containers [--rebuild "docker compose build"] [--json]

Start the run first (SCENARIO=ring-16 docker compose up -d). Memory of other users' processes is for root to see. To
measure a build a comment is added to a file of ours, and taken away again.
"""

import argparse
import contextlib
import json
import re
import secrets
import shlex
import statistics
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import psutil

from runtime.compose import RUN

CHANGED = Path(__file__).parents[1] / "formation" / "units.py"
"""A file of which no kernel is made."""
AGENT = re.compile(rf"^echelon {RUN}: agent \d+")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rebuild", metavar="COMMAND", help="builds the image")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    pss = sorted(_agents())
    if not pss:
        raise SystemExit("expected agents of a run of containers on this machine, and root's rights; got none")
    figures = {"agents": len(pss), "pss_mb": statistics.median(pss), "pss_mb_max": pss[-1], "pss_mb_sum": sum(pss)}
    figures["services_mb"] = sum(_services())
    if options.rebuild:
        figures["rebuild_s"] = _rebuild(shlex.split(options.rebuild))
    if options.json:
        print(json.dumps(figures))
        return
    print(f"{len(pss)} agents, memory (PSS): median {figures['pss_mb']:.0f} MB, largest {pss[-1]:.0f} MB")
    print(f"all processes of the run together: {figures['services_mb']:.0f} MB")
    if options.rebuild:
        print(f"image after a changed line: {figures['rebuild_s']:.1f} s")


def _agents() -> Iterator[float]:
    """PSS of every agent [MB]."""
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if AGENT.match(" ".join(process.cmdline())):
                yield process.memory_full_info().pss / 1e6


def _services() -> Iterator[float]:
    """PSS of every process that has the environment of our containers [MB]."""
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if "ECHELON_IN_CONTAINER" in process.environ():
                yield process.memory_full_info().pss / 1e6


def _rebuild(command: list[str]) -> float:
    """How long the command takes once a line has changed [s]."""
    before = CHANGED.read_text()
    CHANGED.write_text(f"{before}# {secrets.token_hex()}\n")
    began = time.perf_counter()
    try:
        subprocess.run(command, check=True)
    finally:
        CHANGED.write_text(before)
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
