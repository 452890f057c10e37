"""Whether the agents' controllers work, as their commands report it: counts for the summary, changes for the events."""

from collections.abc import Iterable, Mapping

from network.messages import Command
from network.values import Severity

RECOVERED_SECONDS = 1.0
"""After so long without a failure a solver works again [s], so that one that fails now and then is one event."""


class Convergence:
    """Plans made and plans that failed, by robot."""

    def __init__(self) -> None:
        self.plans: dict[int, int] = {}
        """Plans made so far."""
        self.failures: dict[int, int] = {}
        """Of these, plans that are a fallback because the solver did not converge."""
        self._failed_at: dict[int, float] = {}
        self._broken: set[int] = set()

    def reports(
        self, commands: Mapping[int, Command], planned: Iterable[int], now: float
    ) -> list[tuple[str, Severity]]:
        """Count the plans of a tick; texts of the events that its commands report.

        Args:
            commands: of the tick, by robot.
            planned: robots that made a plan for it.
            now: simulated time [s].
        """
        found: list[tuple[str, Severity]] = []
        plans, failed_at = self.plans, self._failed_at
        for robot in planned:
            plans[robot] = plans.get(robot, 0) + 1
            if not commands[robot].converged or robot in failed_at:
                found += self._turn(robot, commands[robot].converged, now)
        for robot, command in commands.items():
            if command.failure and robot not in self._broken:
                self._broken.add(robot)
                text = f"robot {robot} stands still and publishes no plan until a reset: {command.failure}"
                found.append((text, "error"))
        return found

    def _turn(self, robot: int, converged: bool, now: float) -> list[tuple[str, Severity]]:
        """A plan of a robot whose solver fails, or has failed lately: the event if that begins or is over."""
        if not converged:
            self.failures[robot] = self.failures.get(robot, 0) + 1
            begins = robot not in self._failed_at
            self._failed_at[robot] = now
            return [(f"robot {robot}: its solver does not converge: a fallback drives", "error")] if begins else []
        if now - self._failed_at[robot] < RECOVERED_SECONDS - 1e-9:
            return []
        del self._failed_at[robot]
        return [(f"robot {robot}: its solver converges again", "info")]

    def share(self, robot: int) -> float | None:
        """Share of a robot's plans whose solver converged; None before the first plan."""
        plans = self.plans.get(robot, 0)
        return 1.0 - self.failures.get(robot, 0) / plans if plans else None
