"""Bodies that are not ideal, row by row: what disturbs the robots, and what an independent prototype reached there."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from experiments.study import study

SIGHTED = ("G", "H", "J", "J2")
"""Rows in which robots see their upstream neighbour."""
THROWN = (0.16, 0.16, 1.0)
"""Bounds of the velocity with which each robot is thrown in row M [m/s, m/s, rad/s]."""

STUDY = {axis.name: axis for axis in study.load("when-talking-pays").axes}
"""The rows and networks are that study's."""


@dataclass(frozen=True, slots=True)
class Row:
    """Robots of one kind, with what happens to them."""

    text: str
    table: Mapping[str, Any]
    """Keys of the scenario."""
    duration: float = 26.0
    """[s]."""
    warmup: float = 10.0
    """Measures start here [s]."""
    thrown: bool = False
    """Whether every robot is thrown from 1.0 to 1.5 s, by a velocity drawn from the seed."""

    def overrides(self, seed: int, robots: int) -> dict[str, Any]:
        """Keys of the scenario, for a seed and so many robots."""
        thrown = {"disturbances": _throws(seed, robots)} if self.thrown else {}
        return {"duration": self.duration, **self.table, **thrown}


def _throws(seed: int, robots: int) -> list[dict[str, Any]]:
    source = np.random.Generator(np.random.Philox(key=[seed, 0]))
    drifts = source.uniform(-1.0, 1.0, (robots, 3)) * THROWN
    return [{"robot": i + 1, "at": 1.0, "until": 1.5, "drift": drift.tolist()} for i, drift in enumerate(drifts)]


TEXTS = {
    "A": "noise only",
    "B": "lag 0.2 s, accelerations limited",
    "C": "scales 5 %, offset 0.02 rad/s",
    "D": "robot 2 pushed for 10 s",
    "D2": "all robots pushed for 10 s",
    "E": "robot 2 at most 0.03 m/s for 8 s",
    "F": "robot 2 slips by half for 10 s",
    "L": "robot 2 stuck for 3 s",
    "G": "localisation by a camera, and sight",
    "H": "as G; robot 2 not localised for 10 s",
    "I": "commands 0.2 s late",
    "J": "all that a camera's robots have",
    "J2": "as J, two of them disturbed",
}
ROWS: Mapping[str, Row] = {
    **{label: Row(text, STUDY["row"].overrides(label)) for label, text in TEXTS.items()},
    "M": Row("all robots thrown", STUDY["row"].overrides("A"), duration=20.0, warmup=0.0, thrown=True),
}
NETWORKS: Mapping[str, Mapping[str, Any]] = {
    str(label): STUDY["network"].overrides(label) for label in STUDY["network"].labels
}
"""Faults of every link between robots; a burst counts plans, one every second tick."""
DEAF, SEES = "virtual_structure", "virtual_structure sees"
CONTROLLERS: Mapping[str, Mapping[str, Any]] = {
    DEAF: {"controller": {"name": "virtual_structure"}},
    SEES: {"controller": {"name": "virtual_structure", "sees": True}},
    "nash": {},
    "nash hears both": {"controller": {"hears": "both"}},
    "nash window 3": {"estimator": {"window": 3}},
}
NEEDS_SIGHT = (SEES, "nash window 3")
"""Contenders that differ from others only where robots see each other."""


@dataclass(frozen=True, slots=True)
class Prototype:
    """What the prototype reached in a row: RMS l_e over 10 seeds [mm], by network in the order of NETWORKS."""

    nash: tuple[float, ...]
    both: tuple[float, ...] = ()
    deaf: float | None = None
    sees: float | None = None
    jitter: tuple[float, ...] = field(default=())
    """Of `nash`: RMS change of the commanded v from tick to tick [mm/s], on time and late."""

    def of(self, controller: str, network: str) -> float | None:
        """The figure of one cell; None if it was not measured."""
        if controller in (DEAF, SEES):
            return self.deaf if controller == DEAF else self.sees
        figures = {"nash": self.nash, "nash hears both": self.both}.get(controller, ())
        index = list(NETWORKS).index(network)
        return figures[index] if index < len(figures) else None


PROTOTYPE: Mapping[str, Prototype] = {
    "A": Prototype((0.385, 0.397, 0.389), (0.381, 0.391), 0.403, jitter=(1.11, 1.10)),
    "B": Prototype((0.453, 0.475, 0.460), (0.442, 0.464), 0.488, jitter=(3.42, 3.50)),
    "C": Prototype((0.386, 0.397, 0.389), (0.381, 0.392), 0.404, jitter=(1.11, 1.10)),
    "D": Prototype((0.646, 0.710, 0.668), (0.613, 0.707), 0.737, jitter=(1.28, 1.27)),
    "D2": Prototype((0.470, 0.501, 0.484), (0.460, 0.497), 0.508, jitter=(1.88, 1.56)),
    "E": Prototype((0.684, 2.09, 1.03), (0.503, 1.26), 14.5, jitter=(2.11, 1.82)),
    "F": Prototype((0.473, 0.496, 0.489), (0.464, 0.485), 0.503, jitter=(1.49, 1.47)),
    "L": Prototype((1.12, 4.49, 1.50), (0.927, 2.00), 17.6, jitter=(1.93, 2.08)),
    "G": Prototype((0.706, 0.738, 0.717), (0.704, 0.734), 1.143, 0.794, jitter=(1.61, 1.37)),
    "H": Prototype((0.766, 0.783, 0.772), (0.745, 0.770), 3.70, 0.807, jitter=(1.62, 1.38)),
    "I": Prototype((0.595, 0.614, 0.601), (0.588, 0.606), 0.624, jitter=(1.20, 1.16)),
    "J": Prototype((0.820, 0.876, 0.834), (0.814, 0.867), 1.257, 0.956, jitter=(3.80, 3.40)),
    "J2": Prototype((1.771, 1.98, 1.82), (1.74, 1.93), 2.63, 2.37, jitter=(7.35, 7.65)),
}
"""By row. Bounds are 1.05 of these and two standard errors."""
