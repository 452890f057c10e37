"""`echelon new`: a file to begin with, and its test."""

import argparse
import re
from pathlib import Path

from formation.errors import EchelonError
from formation.scenario.registry import check_free

CONTROLLER = '''\
"""A controller of one's own: every robot drives to its slot. Try: echelon run --controller ./{file}:{name}"""
import numpy as np
from echelon import Observation, Solution

class {name}:
    def __init__(self, task, options):
        self.limits = task.limits  # [m/s, rad/s]

    def plan(self, observation: Observation) -> Solution:
        slot, inputs = observation.reference.slots[0], observation.reference.inputs.copy()
        c, s, (x, y) = np.cos(slot[2]), np.sin(slot[2]), slot[:2] - observation.pose[:2]
        v, turn = inputs[0, 0], np.sin(slot[2] - observation.pose[2])
        inputs[0] += 2 * (c * x + s * y), 2 * turn + 10 * v * (c * y - s * x)
        return Solution(np.clip(inputs, -self.limits, self.limits))
'''
TEST = '''\
"""The test of {file}: pytest {test}"""
from pathlib import Path

import echelon

FILE = Path(__file__).with_name("{file}")


def test_it_holds_the_triangle() -> None:
    scenario = echelon.load("triangle-circle", {{"duration": 20, "robots": {{}}}}, controller=f"{{FILE}}:{name}")
    assert abs(echelon.simulate(scenario).distance_errors).max() < 1e-3
'''


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("kind", choices=["controller"], help="what is to be written")
    parser.add_argument("name", help="of its class, such as HoldSlot")


def run(options: argparse.Namespace) -> None:
    """Write the file and its test into the current folder; nothing is overwritten."""
    name: str = options.name
    if not name.isidentifier():
        raise EchelonError(f"expected the name of a class, such as HoldSlot; got {name!r}")
    check_free(name)
    stem = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
    words = {"name": name, "file": f"{stem}.py", "test": f"test_{stem}.py"}
    texts = {words["file"]: CONTROLLER, words["test"]: TEST}
    there = [file for file in texts if Path(file).exists()]
    if there:
        raise EchelonError(f"expected files that are not there yet; {', '.join(there)} would be overwritten")
    for file, text in texts.items():
        Path(file).write_text(text.format(**words), encoding="utf-8")
        print(file)
