"""Bodies that are not ideal: pattern error and jitter by row, network and controller, each beside its bound.

python -m benchmarks.bodies [--rows A,E] [--networks "on time,late"] [--controllers nash] [--seeds 1000:1020] [--json]

The triangle on the circle at 0.1 m spacing, started in formation, a plan every second tick. l_e: RMS over robots and
ticks from 10 s on (row M: over the whole run), mean over seeds. Ratios are those of the means, with the standard error
of the paired differences. A controller that uses no plan is simulated on time only.

With --equal-jitter every rival first gets weights with which it has the jitter of `nash` (benchmarks/equal_jitter.py).
"""

import argparse
import json
import math
import statistics
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from benchmarks import equal_jitter
from benchmarks.bodies_cells import Cell, commit, paired_ratio
from benchmarks.bodies_rows import CONTROLLERS, DEAF, NEEDS_SIGHT, NETWORKS, PROTOTYPE, ROWS, SEES, SIGHTED
from benchmarks.rivals import RIVALS
from experiments.trials.code_version import code_version
from experiments.trials.pool import cores, local
from runtime.precompile import ensure_compiled

SLACK = 1.05
JITTER_SLACK = 1.1


@dataclass(frozen=True, slots=True)
class Found:
    """One line of the table."""

    row: str
    network: str
    controller: str
    l_e: float
    error: float
    """Standard error of l_e."""
    centre: float
    jitter: float
    bound: float | None
    jitter_bound: float | None
    against: dict[str, tuple[float, float]]
    """Ratio to a rival that uses no plan, and its standard error."""

    @property
    def kept(self) -> bool | None:
        """Whether the bounds are kept; None without any."""
        if self.bound is None:
            return None
        return self.l_e <= self.bound and (self.jitter_bound is None or self.jitter <= self.jitter_bound)

    def line(self) -> str:
        """As it is printed."""
        wrong = "L_E NOT KEPT" if self.bound is not None and self.l_e > self.bound else "JITTER NOT KEPT"
        bound = "" if self.bound is None else f"bound {self.bound:.3f} {'kept' if self.kept else wrong}"
        ratios = "  ".join(
            f"{100 * (r - 1):+.1f} +- {100 * e:.1f} % of {rival}" for rival, (r, e) in self.against.items()
        )
        return (
            f"{self.row:3} {self.network:8} {self.controller:22} l_e {self.l_e:7.3f} +- {self.error:.3f} mm  "
            f"{bound:22}  centre {self.centre:6.2f} mm  jitter {self.jitter:5.2f} mm/s  {ratios}"
        )


Results = dict[Cell, dict[str, Any]]


def cells(rows: Sequence[str], networks: Sequence[str], controllers: Sequence[str], seeds: range) -> list[Cell]:
    """Every simulation that is wanted, a row after the other; who uses no plan needs no network."""
    return [
        Cell(row, network, controller, seed)
        for row in rows
        for network in networks
        for controller in controllers
        if (row in SIGHTED or controller not in NEEDS_SIGHT)
        and (controller not in (DEAF, SEES) or network == networks[0])
        for seed in seeds
    ]


def found(results: Results, seeds: range) -> Iterator[Found]:
    """Lines of the table, for every cell of which all seeds are there."""
    for row, network, controller in dict.fromkeys((cell.row, cell.network, cell.controller) for cell in results):
        values = [results[Cell(row, network, controller, seed)] for seed in seeds]
        l_e = [value["l_e"] for value in values]
        error = statistics.stdev(l_e) / math.sqrt(len(l_e)) if len(l_e) > 1 else 0.0
        prototype = PROTOTYPE.get(row)
        figure = prototype.of(controller, network) if prototype else None
        jitter_bound = None
        if prototype and controller == "nash" and network in list(NETWORKS)[:2]:
            jitter_bound = JITTER_SLACK * prototype.jitter[list(NETWORKS).index(network)]
        yield Found(
            row,
            network,
            controller,
            statistics.fmean(l_e),
            error,
            statistics.fmean(value["centre"] for value in values),
            statistics.fmean(value["jitter"] for value in values),
            None if figure is None else SLACK * figure + 2.0 * error,
            jitter_bound,
            {} if controller in (DEAF, SEES) else _against(results, row, seeds, l_e),
        )


def _against(results: Results, row: str, seeds: range, l_e: Sequence[float]) -> dict[str, tuple[float, float]]:
    """Ratios of the means of l_e to rivals that use no plan, where they were simulated too."""
    ratios = {}
    for rival in (DEAF, SEES):
        network = next((cell.network for cell in results if cell.row == row and cell.controller == rival), None)
        if network is None:
            continue
        other = [results[Cell(row, network, rival, seed)]["l_e"] for seed in seeds]
        ratios[rival] = paired_ratio(l_e, other)
    return ratios


def main() -> int:
    """Simulate, print a table row by row."""
    options = _options()
    began = perf_counter()
    ensure_compiled(lambda text: print(text, file=sys.stderr))
    pool = local(options.workers)
    if options.equal_jitter:
        plan = equal_jitter.Plan(options.rows, options.networks, options.rivals, options.tuning, options.seeds)
        return equal_jitter.compare(plan, pool, options.out, as_json=options.json)
    lines: list[Found] = []
    for row in options.rows:
        work = cells([row], options.networks, options.controllers, options.seeds)
        done = {piece: result for piece, result in pool(work) if isinstance(piece, Cell)}
        fresh = list(found({cell: done[cell] for cell in work}, options.seeds))
        lines += fresh
        if not options.json:
            print(f"{row}: {ROWS[row].text}", *(one.line() for one in fresh), sep="\n", flush=True)
    seconds = perf_counter() - began
    if options.json:
        rows = [{**{name: getattr(one, name) for name in Found.__slots__}, "kept": one.kept} for one in lines]
        seeds = [options.seeds.start, options.seeds.stop]
        print(json.dumps({"commit": commit(), "code": code_version(), "seeds": seeds, "wall_s": seconds, "rows": rows}))
    else:
        bounded = [one for one in lines if one.bound is not None]
        kept = sum(one.kept is True for one in bounded)
        print(f"{kept} of {len(bounded)} bounds kept; {len(options.seeds)} seeds, {seconds:.0f} s, commit {commit()}")
    return 0 if all(one.kept is not False for one in lines) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=names_of(ROWS), default=list(ROWS), metavar="A,B")
    parser.add_argument("--networks", type=names_of(NETWORKS), default=list(NETWORKS))
    parser.add_argument("--controllers", type=names_of(CONTROLLERS), default=list(CONTROLLERS))
    parser.add_argument(
        "--seeds", type=seeds_of, default=range(1000, 1002), metavar="FROM:TO", help="20 for the record"
    )
    tuned = parser.add_argument_group("rivals with the jitter of nash")
    tuned.add_argument("--equal-jitter", action="store_true")
    tuned.add_argument("--rivals", type=names_of(RIVALS), default=list(RIVALS))
    tuned.add_argument("--tuning", type=seeds_of, default=range(8), metavar="FROM:TO", help="seeds of the search")
    tuned.add_argument("--out", type=Path, help="folder for results so far, from where the same command goes on")
    parser.add_argument("--workers", type=int, default=cores())
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def names_of(known: Any) -> Any:
    """A reader of names that are separated by commas."""

    def parsed(text: str) -> list[str]:
        names = [name.strip() for name in text.split(",")]
        wrong = [name for name in names if name not in known]
        if wrong:
            raise argparse.ArgumentTypeError(f"expected some of {', '.join(known)}; got {wrong[0]!r}")
        return names

    return parsed


def seeds_of(text: str) -> range:
    """From "1000:1020"."""
    low, _, high = text.partition(":")
    return range(int(low), int(high))


if __name__ == "__main__":
    sys.exit(main())
