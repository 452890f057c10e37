"""Rivals of `nash` at its jitter: `python -m benchmarks.bodies --equal-jitter`.

Per row, network and rival, a factor on R_v and one on R_omega (or one on the gains, where there are no weights) are
searched, on seeds of their own, until the commanded v and omega both jump from tick to tick as those of `nash`, to
within 7 % (medians over seeds). R_omega decides how omega jumps and the error, and hardly how v jumps: with the jitter
of v alone the weights of a rival would be free. Then l_e of `nash` over that of the rival is measured on the held-out
seeds, with two standard errors of the paired differences. A rival with one factor has neither jitter above, and one of
them at, that of `nash`.
"""

import json
import math
import statistics
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from benchmarks.bodies_cells import Cell, commit, paired_ratio
from benchmarks.rivals import RIVALS, Knob, Tuned
from experiments.trials.code_version import code_version
from experiments.trials.journal import Journal
from experiments.trials.pool import Pool, Work, finish

NEAR, EQUAL = math.log(1.07), math.log(1.1)
"""Ratio of jitters at which the search ends, and at which they count as equal."""
BOUND = math.log(1000.0)
"""Factors are from 1/1000 to 1000."""
ROUNDS = 7
EVERY = 15.0
"""Between two lines of progress [s]."""

Values = dict[str, float]
Jitters = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Plan:
    """What is compared."""

    rows: Sequence[str]
    networks: Sequence[str]
    rivals: Sequence[str]
    tuning: Sequence[int]
    """Seeds of the search."""
    seeds: Sequence[int]
    """Held-out seeds, by which the comparison goes."""

    def cells(self) -> list[tuple[str, str, str]]:
        """Row, network and rival of every comparison."""
        return [(a, b, c) for c in self.rivals for a in self.rows if a in RIVALS[c].rows for b in self.networks]


class Search:
    """The search of one rival's factors in one row and network."""

    def __init__(self, row: str, network: str, rival: str, target: Jitters) -> None:
        """Nothing tried yet.

        Args:
            row, network, rival: where.
            target: jitter of v and of omega of `nash` there, on the seeds of the search.
        """
        self.row, self.network, self.rival, self._target = row, network, rival, target
        self._speed, self._turn = (Knob(slope, NEAR, BOUND) for slope in RIVALS[rival].slopes)
        self._tried: list[tuple[float, Jitters, Jitters]] = []
        self.done = False

    def works(self, seeds: Iterable[int], factors: Jitters | None = None) -> list[Tuned]:
        """Simulations with these factors, or with those to try next."""
        speed, turn = factors or (math.exp(self._speed.at), math.exp(self._turn.at))
        heard = self.network if RIVALS[self.rival].hears else "on time"
        return [Tuned(self.row, heard, self.rival, speed, turn, seed) for seed in seeds]

    def tell(self, values: Sequence[Values]) -> None:
        """Results of the simulations with the factors that were to be tried."""
        factors = math.exp(self._speed.at), math.exp(self._turn.at)
        found = jitters(values)
        v, omega = (math.log(max(a, 1e-9) / b) for a, b in zip(found, self._target, strict=True))
        if RIVALS[self.rival].single:
            v = omega = max(v, omega)
        self._tried.append((abs(v) + abs(omega), factors, (v, omega)))
        if not RIVALS[self.rival].single:
            self._speed.tell(v)
        self._turn.tell(omega)
        self.done = self._turn.settled and (self._speed.settled or RIVALS[self.rival].single)

    @property
    def best(self) -> Jitters:
        """The factors of those tried that led nearest."""
        return min(self._tried)[1]


@dataclass(frozen=True, slots=True)
class Compared:
    """`nash` beside one rival at its jitter, on the held-out seeds."""

    row: str
    network: str
    rival: str
    speed_factor: float
    """On the rival's R_v."""
    turn_factor: float
    """On its R_omega, or one over the factor on its gains."""
    jitter: float
    """Of v, over that of `nash`."""
    turn_jitter: float
    """Of omega, likewise."""
    l_e: float
    """Of `nash` [mm]."""
    rival_l_e: float
    centre: float
    """Of `nash`: distance of the centre from the path [mm]."""
    rival_centre: float
    ratio: float
    error: float
    """Standard error of the ratio."""

    @property
    def worse(self) -> bool:
        """Whether `nash` is worse by more than two standard errors."""
        return self.ratio - 1.0 > 2.0 * self.error

    @property
    def equal(self) -> bool:
        """Whether the jitter is that of `nash`: both inputs', or the rougher one's where there is one factor."""
        v, omega = math.log(self.jitter), math.log(self.turn_jitter)
        if RIVALS[self.rival].single:
            return abs(max(v, omega)) <= EQUAL
        return max(abs(v), abs(omega)) <= EQUAL

    def line(self) -> str:
        """As it is printed."""
        percent, error = 100.0 * (self.ratio - 1.0), 200.0 * self.error
        verdict = (
            f"WORSE by {percent:.1f} % +- {error:.1f}" if self.worse else f"no worse ({percent:+.1f} +- {error:.1f} %)"
        )
        return (
            f"{self.row:3} {self.network:8} {self.rival:23} {verdict:32} "
            f"l_e {self.l_e:7.3f} / {self.rival_l_e:7.3f} mm  "
            f"centre {self.centre:.2f} / {self.rival_centre:.2f} mm  "
            f"jitter of v x {self.jitter:.2f}, of omega x {self.turn_jitter:.2f}{'' if self.equal else ' NOT EQUAL'}  "
            f"(factors {self.speed_factor:.3g}, {self.turn_factor:.3g})"
        )


def jitters(values: Sequence[Values]) -> Jitters:
    """Of v [mm/s] and of omega [mrad/s]: medians over seeds; one run in which a robot is lost doubles the mean."""
    v, omega = (statistics.median(value[name] for value in values) for name in ("jitter", "turn_jitter"))
    return v, omega


def _mean(values: Sequence[Values], name: str) -> float:
    return statistics.fmean(value[name] for value in values)


Do = Callable[[str, Sequence[Sequence[Work]]], list[list[Values]]]


def searched(plan: Plan, do: Do) -> list[Search]:
    """Every search, at its end."""
    cells = plan.cells()
    places = list(dict.fromkeys((row, network) for row, network, _ in cells))
    of_nash = do("nash", [[Cell(*place, "nash", seed) for seed in plan.tuning] for place in places])
    targets = {place: jitters(values) for place, values in zip(places, of_nash, strict=True)}
    searches = [Search(row, network, rival, targets[row, network]) for row, network, rival in cells]
    for number in range(ROUNDS):
        going = [search for search in searches if not search.done]
        found = do(f"search {number + 1}", [search.works(plan.tuning) for search in going])
        for search, values in zip(going, found, strict=True):
            search.tell(values)
    return searches


def comparisons(plan: Plan, do: Do) -> list[Compared]:
    """All that is compared."""
    searches = searched(plan, do)
    works: list[Sequence[Work]] = []
    for search in searches:
        works.append([Cell(search.row, search.network, "nash", seed) for seed in plan.seeds])
        works.append(search.works(plan.seeds, search.best))
    found = do("compare", works)
    return [
        _compared(search, ours, theirs) for search, ours, theirs in zip(searches, found[::2], found[1::2], strict=True)
    ]


def _compared(search: Search, ours: Sequence[Values], theirs: Sequence[Values]) -> Compared:
    (v, omega), (other_v, other_omega) = jitters(ours), jitters(theirs)
    ratio, error = paired_ratio([value["l_e"] for value in ours], [value["l_e"] for value in theirs])
    return Compared(
        search.row,
        search.network,
        search.rival,
        *search.best,
        other_v / v,
        other_omega / omega,
        _mean(ours, "l_e"),
        _mean(theirs, "l_e"),
        _mean(ours, "centre"),
        _mean(theirs, "centre"),
        ratio,
        error,
    )


def compare(plan: Plan, pool: Pool, out: Path | None, *, as_json: bool) -> int:
    """Search, compare and print.

    Args:
        plan: what is compared.
        pool: who simulates.
        out: folder of results so far; None: a temporary one.
        as_json: print one object instead of lines.

    Returns:
        0 if `nash` is no worse anywhere, else 1.
    """
    began = perf_counter()
    with TemporaryDirectory() as temporary, Journal(out or Path(temporary)) as journal:
        lines = comparisons(plan, lambda stage, works: _finished(stage, works, journal, pool))
    seconds = perf_counter() - began
    worse = sum(line.worse for line in lines)
    if as_json:
        rows = [{**asdict(line), "worse": line.worse, "equal": line.equal} for line in lines]
        head = {"commit": commit(), "code": code_version(), "tuning": list(plan.tuning), "seeds": list(plan.seeds)}
        print(json.dumps({**head, "wall_s": seconds, "factors": [math.exp(-BOUND), math.exp(BOUND)], "rows": rows}))
    else:
        print(*(line.line() for line in lines), sep="\n")
        print(
            f"no worse in {len(lines) - worse} of {len(lines)} cells, at equal jitter in "
            f"{sum(line.equal for line in lines)}; {len(plan.seeds)} seeds, {len(plan.tuning)} for the search, "
            f"{seconds:.0f} s, commit {commit()}"
        )
    return 1 if worse else 0


def _finished(stage: str, works: Sequence[Sequence[Work]], journal: Journal, pool: Pool) -> list[list[Any]]:
    """Results in the same order; a line of progress now and then."""
    began = last = perf_counter()

    def progress(_: float, done: int, total: int, fresh: bool) -> None:
        nonlocal last
        if done == total or (fresh and perf_counter() - last > EVERY):
            last = perf_counter()
            print(f"{stage}: {done} of {total} simulations, {last - began:.0f} s", file=sys.stderr, flush=True)

    flat = iter(finish([work for some in works for work in some], journal, pool, progress)) if works else iter(())
    return [[next(flat) for _ in some] for some in works]
