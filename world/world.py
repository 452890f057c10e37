"""The world without any I/O: a tick out, commands in, one step; and the operations of its users.

It reads no clock. Its caller (runtime/inprocess.py, world/process.py) decides when the next tick is due.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from formation.disturbances import Disturbance, displacement, pushed
from formation.errors import EchelonError, ScenarioError
from formation.faults import PERFECT, Fault
from formation.formation_spec import Change
from formation.link_ids import LinkId
from formation.scenario.reshaping import change_of, closing, reshaped
from formation.scenario.scenario import Scenario
from network.control import Operation
from network.interventions import Join, Leave, Move, Push, Release, Reshape
from network.messages import WORLD, Command, Tick
from network.values import NO_DRIVE, NO_PLACES, NO_POSES, Intervention, maker
from world.episode import Episode
from world.states import SKIPPED

_make_tick = maker(Tick)


class World(Episode):
    """An episode that goes on tick by tick; `reset` starts a new one."""

    # ------------------------------------------------------------------ stepping

    def tick(self) -> Tick:
        """The Tick of now; the same message until `advance`."""
        if self._tick is None:
            k, plant, measured = self.k, self.plant, self.plant.measure()
            # By place, in the order of network.messages.Tick, as agents make their plans.
            self._tick = _make_tick(
                WORLD,
                k,
                self.now,
                self.episode,
                self.revision,
                plant.odometry,
                self._planned,
                measured.tick if measured else None,
                measured.poses if measured else NO_POSES,
                measured.localised if measured else [],
                measured.relatives if measured else NO_PLACES,
                not self.endless and k == self.scenario.ticks - 1,
                [],
                self._sight.see(k, plant.poses),
                self.driver.message(k) if self.driver else NO_DRIVE,
            )
        return self._tick

    def advance(self, commands: Mapping[int, Command]) -> None:
        """Step by one tick, with the commands that were received for this one."""
        now = self.now
        acted = self._commands.take(commands, now)
        self.inputs = inputs = np.array(acted)
        for text, severity in self._commands.reports():
            self.event("watchdog", text, severity)
        self.plant.move(inputs)
        self._note(commands, acted, now)
        self.k += 1
        self._tick = None
        self._look()
        self._drive()
        self._act(self.now)
        self._keep_ledger(commands)

    def _note(self, commands: Mapping[int, Command], acted: list[tuple[float, float]], now: float) -> None:
        """Keep what robots did at a tick that began at `now` [s]: their commands, and the inputs that they acted on."""
        planned = [robot for robot, command in commands.items() if command.planned]
        if self.trace:
            self.trace.add(self.plant.poses, self.inputs, commands, planned)
        for text, severity in self.convergence.reports(commands, planned, now):
            self.event("agent", text, severity)
        for text in self.at_limits.reports(commands, now):
            self.event("avoidance", text)
        self._planned = sorted(planned)
        self.at_limits.add(acted, self.plant.poses)

    def _act(self, now: float) -> None:
        """Begin and end what is due at `now` [s]: membership of the ring, faults and disturbances."""
        self.members.look(self.k, self.live)
        if self.members.away != self.away:
            self._close_ring()
        if now >= self.faults.due:
            self._apply_faults()
        if now >= self.interventions.due:
            self._note_pushes()

    def _apply_faults(self) -> None:
        changed = self.faults.update(self.now)
        for link, fault in changed:
            self.event("fault", f"{link}: {fault.words()}", "info" if fault == PERFECT else "warning")
        if changed:
            self.revision += 1
            self._commands.set_faults(self.faults.table)

    def forget_plans(self, robots: Collection[int]) -> None:
        """At the next tick nobody has the plans that these robots sent at the one before: they are lost since."""
        self._planned = [robot for robot in self._planned if robot not in robots]
        if self._tick is not None:
            self._tick = replace(self._tick, planned=self._planned)

    def reset(self) -> None:
        """Start a new episode; faults that users set without an end stay."""
        overrides = self.faults
        self._next_episode()
        overrides.restart()
        overrides.close_over(self.away)
        overrides.update(0.0)
        self.faults = overrides
        self._commands.set_faults(self.faults.table)
        self.event("run", "reset")

    def use(self, scenario: Scenario) -> None:
        """Start an episode of another scenario, without the faults that users set."""
        self.given = scenario
        self._next_episode()
        self.event("run", f"scenario {scenario.name}, controller {scenario.controller.name}, seed {scenario.seed}")

    def _next_episode(self) -> None:
        self.episode += 1
        self.revision += 1
        live = self.live
        self._begin()
        self.live = live & set(self.robots)

    def go_on(self) -> None:
        """This is a saved state: begin a segment of the episode, in which every agent begins anew."""
        self.episode, self.revision = self.episode + 1, self.revision + 1
        self.resumed.append(self.k)
        self._event_count, self._planned = self._event_count + SKIPPED, []
        if self._tick is not None:  # the sensors measure once per tick
            self._tick = replace(self._tick, episode=self.episode, revision=self.revision, planned=[])
        text = f"the world was lost: segment {len(self.resumed) + 1} goes on from here, every agent begins anew"
        self.event("run", text, "warning")

    def change_fault(self, link: str, changes: Mapping[str, Any], until: float | str | None) -> None:
        """Set keys of a fault from the next tick on, until a simulated time [s] or for good. Raises FaultError."""
        self.faults.change(link, changes, until, self.now)
        self._apply_faults()

    def clear_faults(self, link: str) -> None:
        """Remove what users set on a link, or on "all", from the next tick on. Raises FaultError."""
        self.faults.clear(link, self.now)
        self._apply_faults()

    def impose_faults(self, table: Mapping[LinkId, Fault]) -> None:
        """Use exactly these faults from the next tick on: this world repeats another's."""
        self.faults.impose(table)
        self._apply_faults()

    def intervene(self, operation: Operation) -> None:
        """Do something to the robots: push, move, release, reshape. Raises EchelonError."""
        match operation:
            case Push(robot=robot, kind=kind, seconds=seconds):
                if seconds is not None and not self.now < self.now + seconds - 1e-9:
                    raise EchelonError(f"seconds: expected some time, for it to act at all; got {seconds:g}")
                self.push(pushed(robot, kind, self.now, seconds))
            case Move(robot=robot, dx=dx, dy=dy):
                self.push(displacement(robot, dx, dy, self.now, self.scenario.control_interval))
            case Leave(robot=robot):
                self.members.leave(robot)
                self._close_ring()
            case Join(robot=robot):
                self.members.join(robot)
                self._close_ring()
            case Release(robot=robot):
                self.release(robot)
            case Reshape(shape=shape, spacing=spacing, over=over):
                away = self.away if self.scenario.membership.shape == "close" else ()
                change = change_of(self.scenario, self.path_time, shape=shape, spacing=spacing, over=over, away=away)
                self.reshape(change, shape or "")
            case _:
                raise EchelonError(f"expected push, move, release or shape; got {type(operation).__name__}")

    def push(self, disturbance: Disturbance) -> None:
        """Disturb a robot's body. Raises EchelonError."""
        if disturbance.robot > self.scenario.size:
            raise EchelonError(f"robot: expected 1 to {self.scenario.size}; got {disturbance.robot}")
        self.interventions.push(self.k, self.now, disturbance)
        self._note_pushes()

    def release(self, robot: int | None) -> None:
        """End what disturbs a robot, or all of them. Raises EchelonError."""
        if robot is not None and robot > self.scenario.size:
            raise EchelonError(f"robot: expected 1 to {self.scenario.size}; got {robot}")
        self.interventions.release(self.k, self.now, robot)
        self._note_pushes()

    def reshape(self, change: Change, name: str = "") -> None:
        """Change the shape from the next tick on, as if the scenario had that change. Raises ScenarioError.

        Args:
            change: with each robot's place.
            name: of the shape, for the log.
        """
        scenario = reshaped(self.given, [*self.interventions.changes, change])
        self.interventions.reshape(self.k, change)
        self._take_shape(scenario)
        self.event("push", f"the shape becomes {name or 'another'}, spacing {change.spacing:.3g} m")

    def _close_ring(self) -> None:
        """As before; with `membership.shape = "close"` those who stay take the shape for as many as they are."""
        before = self.away
        super()._close_ring()
        if self.away == before or self.scenario.membership.shape == "keep":
            return
        try:
            change = closing(self.scenario, self.path_time, self.away)
            scenario = reshaped(self.given, [*self.interventions.changes, change])
        except ScenarioError as error:
            self.event("agent", f"the robots keep their places: {error}", "warning")
            return
        self.interventions.close(change)
        self._take_shape(scenario)

    def _take_shape(self, scenario: Scenario) -> None:
        """From now on the formation is that of this scenario."""
        self.scenario = scenario
        if self.driver:
            self.driver.reshape(self.k, scenario)
        else:
            self.reference = scenario.reference()
            if self.trace:
                self.trace.reference = self.reference
        self.revision += 1

    @property
    def path_time(self) -> float:
        """The path's time now: the clock, less what all robots are late [s]."""
        return self.now - self.reference.lag(self.now)

    def repeat(self, intervention: Intervention) -> None:
        """Do what was done to another world at this tick."""
        match intervention.kind:
            case "push":
                self.push(Disturbance.model_validate(intervention.value))
            case "release":
                self.release(intervention.value["robot"])
            case "shape":
                self.reshape(Change.model_validate(intervention.value))
            case "ring":
                self.members.impose(intervention.value["away"])
                self._close_ring()
