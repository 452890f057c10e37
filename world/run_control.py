"""The operations that users request of a run: state of the run, and their execution."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from formation.errors import EchelonError, ScenarioError, unknown
from formation.faults import preset
from formation.scenario.controllers import SHARED_KEYS
from formation.scenario.files import load, parse, shipped
from formation.scenario.registry import check_live, check_name
from formation.scenario.scenario import Scenario
from network import control
from network.control import Operation
from network.interventions import Join, Leave, Move, Push, Release, Reshape
from network.requests import TraceRows, packed
from network.stretch import Recording
from network.values import RecordWish, RunStatus
from world.driver import Driver
from world.presence import AgentPresence
from world.rate import Rate
from world.world import World

BETWEEN_TICKS = (
    control.SetFault,
    control.SetPreset,
    control.Clear,
    control.Step,
    control.Drive,
    control.GoTo,
    Push,
    Move,
    Release,
    Reshape,
    Leave,
    Join,
)
"""Operations that wait for the end of a tick: what they change must be the same for everybody who answers it."""
READS = (control.GetOrders, control.GetTrace, control.GetSummary)
"""Operations that change nothing."""


class RunControl:
    """Whether to run, and for how many ticks; carries out the requested operations."""

    def __init__(self, world: World, rate: Rate, presence: AgentPresence, *, go: bool) -> None:
        self._world, self._rate, self._presence = world, rate, presence
        self._go = go
        self._ticks_left = 0  # of a Step
        self.stop = False
        """Whether a user has asked the run to end."""
        self.compare = ""
        """Controller of the requested ghost; empty for none."""
        self.record: RecordWish = ""
        self.recording: Recording | None = None
        """How the record stands; None while there is no recorder."""
        self.changes = 0
        """Operations that may have changed something, so far."""
        self.rejected = 0
        """For the summary: payloads that were not valid messages."""

    @property
    def status(self) -> RunStatus:
        """The run's status now."""
        world = self._world
        if world.finished:
            return "finished"
        if not world.live or (world.k == 0 and set(self._presence.missing) - set(self._presence.dismissed)):
            return "waiting"
        return "running" if self._go else "paused"

    @property
    def active(self) -> bool:
        """Whether the next tick may be sent."""
        status = self.status
        return status == "running" or (status == "paused" and self._ticks_left > 0)

    @property
    def calling(self) -> bool:
        """Whether the next tick may be sent although nobody is live, for those who did not answer to answer again."""
        return self._go and not (self._world.finished or self._world.live) and bool(self._presence.failed)

    def note_tick(self) -> None:
        """Count a tick."""
        self._ticks_left = max(0, self._ticks_left - 1)

    def obey(self, operation: Operation) -> dict[str, Any]:
        """Carry out the operation; the value is the reply's.

        Raises:
            EchelonError: it cannot be done; the text gives the reason.
        """
        world = self._world
        self.changes += not isinstance(operation, READS)
        match operation:
            case control.Start():
                if world.finished:
                    self._reset()
                self._go = True
            case control.Pause():
                self._go, self._ticks_left = False, 0
            case control.Step(ticks=ticks):
                self._go, self._ticks_left = False, ticks
            case control.Reset():
                self._reset()
            case control.Speed(speed=speed):
                self._rate.speed = speed
            case control.SetFault(link=link, changes=changes, seconds=seconds):
                world.change_fault(link, changes, seconds and world.now + seconds)
            case control.SetPreset(link=link, preset=name, seconds=seconds):
                world.change_fault(link, preset(name).model_dump(), seconds and world.now + seconds)
            case control.Clear(link=link):
                world.clear_faults(link)
            case control.UseScenario():
                self._use(_scenario(operation))
            case control.UseController(controller=name):
                self._use(with_controller(world.given, name))
            case control.Kill() | control.Restart() | control.Record():
                self._have_launcher(operation)
            case control.Compare(controller=name):
                check_name(name, "off")
                if name not in ("off", world.scenario.controller.name):
                    with_controller(world.scenario, name)  # refused here, not in the ghost
                self.compare = "" if name == "off" else name
            case control.Drive(v=v, omega=omega, seconds=seconds):
                return self._drive(lambda driver: driver.order(world.k, v, omega, seconds))
            case control.GoTo(x=x, y=y):
                return self._drive(lambda driver: driver.go_to(world.k, x, y))
            case Push() | Move() | Release() | Reshape() | Leave() | Join():
                world.intervene(operation)
            case control.GetOrders(tables=tables, drives=drives, interventions=interventions):
                return self._orders_since(tables, drives, interventions)
            case control.Stop():
                self.stop = True
            case control.GetTrace(first=first):
                return self._trace(first)
            case control.GetSummary(warmup=warmup):
                rate = self._rate
                figures = {"wall_s": rate.wall, "overruns": rate.overruns, "rejected": self.rejected}
                return {**world.summary(warmup=warmup), **figures}
        return {}

    def _have_launcher(self, operation: control.Kill | control.Restart | control.Record) -> None:
        """What a launcher does, by the next State. Raises EchelonError: there is none, or no such robot."""
        world = self._world
        match operation:
            case control.Kill(robot=robot):
                self._presence.dismiss(robot, for_good=True)
                world.event("run", f"agent {robot} is killed and kept down", "warning")
            case control.Restart(robot=robot):
                kept = self._presence.readmit(robot)
                if not kept:
                    self._presence.dismiss(robot, for_good=False)
                world.event("run", f"agent {robot} is {'started' if kept else 'killed and started'} again")
            case control.Record(on=on):
                self._presence.check_launcher("a recorder", "Give `--record` to `echelon compose`.")
                self.record = "on" if on else "off"

    def _drive(self, order: Callable[[Driver], list[str]]) -> dict[str, Any]:
        """Give the driver an order; the reply's value is what it does from which tick on."""
        world = self._world
        if world.driver is None:
            raise EchelonError(
                f'expected a scenario whose path is driven (path.kind = "driven", such as drive-me); got '
                f"{world.scenario.name}, path {world.scenario.path.kind}"
            )
        for line in order(world.driver):
            world.event("drive", line)
        shown = world.driver.shown
        return {"tick": world.k, "v": shown.v, "omega": shown.omega}

    def _trace(self, first: int) -> dict[str, Any]:
        """Rows of the trace from a tick on, as bytes."""
        trace = self._world.trace
        if trace is None:
            raise EchelonError("expected an episode of known length; got an endless one, of which no trace is kept")
        last = min(len(trace.inputs), first + max(1, control.TRACE_ROWS // self._world.scenario.size))
        begin = first + 1 if first else 0
        errors = trace.measured(begin, last + 1)
        rows = TraceRows(
            episode=self._world.episode,
            robots=self._world.scenario.size,
            ticks=len(trace.inputs),
            last=last,
            poses=packed(trace.poses[begin : last + 1]),
            inputs=packed(trace.inputs[first:last]),
            ages=packed(trace.ages[first:last]),
            **{name: packed(values) for name, values in errors._asdict().items()},
        )
        return rows.model_dump()

    def _orders_since(self, tables: int, drives: int, interventions: int) -> dict[str, Any]:
        world = self._world
        driver = world.driver
        return {
            "episode": world.episode,
            "changes": world.faults.changes,
            "drive_changes": driver.count if driver else 0,
            "resumed": world.resumed,
            "tables": world.faults.since(tables),
            "drives": [(k, *order) for k, order in driver.since(drives)] if driver else [],
            "intervention_changes": world.interventions.count,
            "interventions": [asdict(done) for done in world.interventions.since(interventions)],
        }

    def _reset(self) -> None:
        self._world.reset()
        self._presence.recall()
        self._ticks_left = 0

    def _use(self, scenario: Scenario) -> None:
        check_live(scenario.controller.name)
        self._world.use(scenario)
        self._presence.recall()
        self._ticks_left = 0


def _scenario(wanted: control.UseScenario) -> Scenario:
    """What a client asks for: a shipped scenario or one that it sends, but not a file of this machine."""
    if wanted.table is not None:
        return parse(wanted.table, wanted.overrides)
    if wanted.scenario not in shipped():
        raise ScenarioError(unknown("scenario", wanted.scenario, shipped()))
    return load(wanted.scenario, wanted.overrides)


def with_controller(scenario: Scenario, name: str) -> Scenario:
    """The scenario with another controller; the weights and switches of the previous one are left out.

    Raises:
        ScenarioError: there is no such controller; the text lists them.
    """
    raw = scenario.model_dump(exclude_unset=True)
    before = raw.get("controller", {})
    kept = {key: before[key] for key in SHARED_KEYS if key in before}
    return parse({**raw, "controller": {**kept, "name": name}}, where="controller")
