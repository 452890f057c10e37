"""`echelon run`: one episode from start to end, and its measures."""

import argparse
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from cli.hosting import Hosting, add_hosting, hosting, tell_how_to_join
from cli.options import add_record, add_scenario, add_together, load, record_file, tell, time, together, warn
from cli.terminal.figures import figure
from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from runtime.launcher import LiveRun
from runtime.precompile import ensure_compiled


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    add_scenario(parser)
    parser.add_argument("--engine", choices=["processes", "inprocess"], default="processes", help="default: processes")
    parser.add_argument("--duration", metavar="T", help="simulated time, such as 40 or 2min")
    parser.add_argument("--warmup", type=time, default=0.0, metavar="T", help="measures start at this simulated time")
    parser.add_argument("--realtime", action="store_true", help="step by the wall clock (processes only)")
    add_record(parser)
    add_together(parser)
    add_hosting(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Simulate and print the measures."""
    if options.duration is not None:
        options.settings.append(f"duration={options.duration}")
    scenario, _ = load(options)
    if not 0.0 <= options.warmup < scenario.duration:
        raise EchelonError(f"--warmup: expected 0 to less than {scenario.duration:g} s; got {options.warmup:g}")
    if options.realtime and options.engine == "inprocess":
        raise EchelonError("--realtime: expected --engine processes; in one process there is no wall clock")
    if options.listen is not None and options.engine == "inprocess":
        raise EchelonError("--listen: expected --engine processes; other hosts run processes")
    if together(options) is not None and options.engine == "inprocess":
        raise EchelonError("--together: expected --engine processes; in one process all are together")
    hosts = hosting(options)
    warn(scenario)
    record = record_file(options, scenario.name)
    fault = ""
    with _ProgressBar(scenario) as report:
        if options.engine == "inprocess":
            summary = _inprocess(scenario, options, record, report)
        else:
            summary, fault = _processes(scenario, options, hosts, record, report)
    if record is not None and not fault:
        tell(f"recorded in {record}")
    if options.json:
        print(json.dumps(summary))
    else:
        _print(summary)
    if fault:
        raise EchelonError(f"--record: expected a whole record in {record}; {fault}")
    return 0


def _inprocess(
    scenario: Scenario, options: argparse.Namespace, record: Path | None, report: Callable[[float], None]
) -> dict[str, Any]:
    ensure_compiled(tell)
    from runtime import inprocess, recording  # noqa: PLC0415  half a second, for numba; the other engine has no use

    if record is None:
        return inprocess.simulate(scenario, warmup=options.warmup, progress=report)
    return recording.simulate(scenario, record, detail=options.detail, warmup=options.warmup, progress=report)


def _processes(
    scenario: Scenario,
    options: argparse.Namespace,
    hosts: Hosting,
    record: Path | None,
    report: Callable[[float], None],
) -> tuple[dict[str, Any], str]:
    """The summary, and what is wrong with the record, if anything is."""
    live = LiveRun(
        f"run-{os.getpid()}",
        scenario,
        tell=tell,
        speed=1.0 if options.realtime else 0.0,
        realtime=options.realtime,
        together=options.together,
        record=None if record is None else str(record),
        detail=options.detail,
        **hosts,
    )
    with live:
        tell_how_to_join(live, hosts)
        summary = _finished(live, options.warmup, report)
    return summary, live.record_fault  # known once all processes have ended


def _finished(live: LiveRun, warmup: float, report: Callable[[float], None]) -> dict[str, Any]:
    """The summary of a run that goes on until its end."""
    while live.watch():
        state = live.state
        if state is None:
            continue
        report(state.stamp)
        if state.status == "finished":
            return {**live.summary(warmup), "engine": "processes"}
    raise EchelonError("the run was stopped before its end")


class _ProgressBar:
    """A progress bar on a terminal; silent elsewhere."""

    def __init__(self, scenario: Scenario) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:.0f}/{task.total:.0f} s"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task(scenario.name, total=scenario.duration)

    def __enter__(self) -> Callable[[float], None]:
        self._bar.start()
        return lambda stamp: self._bar.update(self._task, completed=stamp)

    def __exit__(self, *_: object) -> None:
        self._bar.stop()


def excursions(summary: dict[str, Any]) -> str:
    """The excursions of an episode in a line; the way to the slots at the start is none, and is told by itself."""
    found, limit, out = summary["excursions"], 1e3 * summary["excursion_limit_m"], summary["never_within"]
    if len(out) == len(summary["robots"]):
        return f"no robot came within {limit:.3g} mm of where it should be"
    rest = f"; never within {limit:.3g} mm: {', '.join(f'robot {robot}' for robot in out)}" if out else ""
    if not found:
        return f"no error above {limit:.3g} mm once robots were within it{rest}"
    worst = max(found, key=lambda one: float(one["peak_m"]))
    return (
        f"{len(found)} excursions above {limit:.3g} mm; largest: robot {worst['robot']}, "
        f"{1e3 * worst['peak_m']:.3g} mm from t = {worst['t']:.2f} s on; likely cause: {worst['cause']}{rest}"
    )


def _spread(error: dict[str, Any]) -> list[str]:
    """What the table shows of an error [mm]."""
    return [figure(error[key], 1e3, ".4f") for key in ("rms", "median", "p95", "max")]


def _print(summary: dict[str, Any]) -> None:
    console = Console()
    console.print(
        f"[bold]{summary['scenario']}[/] with {summary['controller']}, seed {summary['seed']}: "
        f"{summary['duration']:g} s in {summary['wall_s']:.2f} s ({summary['engine']}), "
        f"measured from {summary['warmup']:g} s"
    )
    errors = Table("pattern error", "rms mm", "median mm", "p95 mm", "max mm", "angle rms rad", "at a limit s")
    for robot, figures in summary["robots"].items():
        d, a = figures["distance_error_m"], figures["angle_error_rad"]
        errors.add_row(
            f"robot {robot}",
            *_spread(d),
            figure(a["rms"], form=".2g"),
            f"{figures['limit_s']:.3g}",
        )
    errors.add_row("centre to path", *_spread(summary["tracking_error_m"]), "", "")
    console.print(errors)
    console.print(excursions(summary))
    console.print(
        f"contacts {summary['contacts']}, least gap of two robots {summary['gap_m'] * 1e3:.3g} mm "
        f"({summary['clearance_m'] * 1e3:.4g} mm between centres)"
    )
    if summary["reference_lag_s"] > 0.0:
        console.print(f"the reference slowed down for all and is {summary['reference_lag_s']:.3g} s late at the end")
    links = Table("link", "sent", "delivered", "lost", "late", "age median s", "p95 s", "max s")
    for link, figures in summary["links"].items():
        age = figures["age_s"]
        ages = [figure(age[key], form=".3f") for key in ("median", "p95", "max")]
        links.add_row(link, *(str(figures[key]) for key in ("sent", "delivered", "lost", "late")), *ages)
    console.print(links)
    solve = summary["solve_s"]
    if solve["median"] is not None:
        console.print(f"a plan takes {solve['median'] * 1e6:.0f} us (median), {solve['p99'] * 1e6:.0f} us (p99)")
    for event in [e for e in summary["events"] if e["kind"] != "run"][-10:]:
        console.print(f"t = {event['t']:.2f} s: {event['text']}", markup=False)
    console.print(f"trajectory {summary['trajectory_sha256']}")
