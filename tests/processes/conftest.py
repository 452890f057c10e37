"""Live runs for tests: each in a folder of its own, with nothing left behind when a test ends."""

from tests.processes.live import compiled, runs, up

__all__ = ["compiled", "runs", "up"]
