"""Rivals of `nash` with weights that can be tuned: same estimator, compensation and weight of the own slot."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from benchmarks.bodies_cells import RowWork, measured, scenario_of
from benchmarks.bodies_rows import DEAF, ROWS, SEES, SIGHTED
from formation.scenario.registry import CONTROLLERS
from runtime.inprocess import Simulation

OWN, SPACING = 120.0, 0.1
"""Weight of an error of one spacing from the own slot, of `nash` without trust; the spacing of the rows [m]."""
SPEED, GAIN = 1.0, 1.25
"""R_v of `nash` and of the pair's game in SI units [s^2/m^2]; gain of `consensus` by default [1/s]."""
LONGEST = math.log(30.0)
"""Longest step of a search."""


@dataclass(frozen=True, slots=True)
class Rival:
    """A contender whose jitter two factors change, one of v and one of omega; larger ones make it smoother."""

    table: Callable[[float, float], Mapping[str, Any]]
    """Keys of [controller] for both factors."""
    slopes: tuple[float, float] = (-0.05, -0.3)
    """About by how much the logarithm of the jitter of v and of omega changes with that of its factor."""
    single: bool = False
    """Whether it has the second factor only, which then changes both."""
    hears: bool = True
    """Whether it uses plans."""
    rows: tuple[str, ...] = field(default=tuple(ROWS))


def _pair(speed: float, turn: float) -> dict[str, Any]:
    """The pair's game with S = 120 and kappa = 0.6: formation = 1, 96 for a position error."""
    place, pattern = 0.8 * OWN, 0.8 * OWN
    q = [place / SPACING**2, place / SPACING**2, 1.0, pattern / SPACING**2, pattern, 1.0]
    return {"name": "nash", "game": "pair", "q": q, "r": [SPEED * speed, turn]}


RIVALS: Mapping[str, Rival] = {
    DEAF: Rival(lambda speed, turn: {"name": DEAF, "r": [SPEED * speed, 0.5 * turn]}, hears=False),
    SEES: Rival(
        lambda speed, turn: {"name": DEAF, "sees": True, "r": [SPEED * speed, 0.4 * turn]}, hears=False, rows=SIGHTED
    ),
    "nash pair": Rival(_pair),
    "consensus": Rival(lambda _, turn: {"name": "consensus", "gain": GAIN / turn}, (0.0, -0.9), single=True),
    "leader_follower": Rival(
        lambda _, turn: {"name": "leader_follower", "errata": [13], "gains": [0.1 / turn, 0.1 / turn]},
        (0.0, -0.1),
        single=True,
    ),
    "paper": Rival(
        lambda speed, turn: {"name": "paper", "errata": [1, 2, 3, 4, 5], "r": [0.1 * speed, 0.1 * turn]}, (-0.3, -0.3)
    ),
}
"""`virtual_structure` deaf and with sight, the pair's game, and the others; those that are shipped as the paper printed
them, on raw poses, get estimates here and their errata mended. Gains take the place of weights where there are none.
Only `virtual_structure` compensates a drift across the heading as `nash` does; the others lack it in their models."""


@dataclass(frozen=True, slots=True)
class Tuned(RowWork):
    """One simulation of a rival with its weights times these factors: work for a pool."""

    row: str
    network: str
    rival: str
    speed: float
    turn: float
    seed: int

    @property
    def name(self) -> str:
        factors = f"{self.rival} x {self.speed:.9g}, {self.turn:.9g}"
        return f"{self.row}, {self.network}, {factors}, seed {self.seed}"

    def run(self) -> dict[str, Any]:
        """As `measured`."""
        table = {"controller": dict(RIVALS[self.rival].table(self.speed, self.turn))}
        with _estimates(table["controller"]["name"]):
            simulation = Simulation(scenario_of(self.row, self.network, table, self.seed))
        return measured(self.row, simulation)


@contextmanager
def _estimates(name: str) -> Iterator[None]:
    """Agents that are made in here get estimates, whichever controller they have."""
    spec = CONTROLLERS[name]
    CONTROLLERS[name] = replace(spec, estimates=True)
    try:
        yield
    finally:
        CONTROLLERS[name] = spec


class Knob:
    """The search of one factor: from logarithms of factors, and of the ratios of jitters that they led to."""

    def __init__(self, slope: float, tolerance: float, bound: float) -> None:
        """Nothing tried yet: it begins with a factor of one.

        Args:
            slope: change of the ratio with the factor, both as logarithms; negative.
            tolerance: largest ratio that is near enough, as a logarithm.
            bound: of the factor, as a logarithm.
        """
        self._slope, self._tolerance, self._bound = slope, tolerance, bound
        self._tried: list[tuple[float, float]] = []
        self.at = 0.0
        """Logarithm of the factor to try next."""
        self.settled = False
        """Whether that was tried already: it is near enough, or the bound of the factor."""

    def tell(self, ratio: float) -> None:
        """The logarithm of the ratio of jitters that the factor led to: sets the next one."""
        self._tried.append((self.at, ratio))
        before = self.at
        if abs(ratio) > self._tolerance:
            self.at = min(max(self._next(), -self._bound), self._bound)
        self.settled = self.at == before

    def _next(self) -> float:
        at, ratio = self._tried[-1]
        rough = [point for point in self._tried if point[1] > 0.0]
        smooth = [point for point in self._tried if point[1] <= 0.0]
        if rough and smooth:
            (low, above), (high, below) = max(rough), min(smooth)
            share = above / (above - below) if low < high else 0.5
            return low + min(max(share, 0.15), 0.85) * (high - low)
        slope = self._slope
        if len(self._tried) > 1 and self._tried[-2][0] != at:
            slope = min((ratio - self._tried[-2][1]) / (at - self._tried[-2][0]), 0.3 * self._slope)
        return at - min(max(ratio / slope, -LONGEST), LONGEST)
