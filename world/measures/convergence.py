"""Whether the agents' controllers work, as their commands report it: counts for the summary, changes for the events."""

from collections.abc import Mapping

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

    def reports(self, commands: Mapping[int, Command], now: float) -> list[tuple[str, Severity]]:
        """Texts of the events that the commands of a tick report; arguments as of `add`."""
        found: list[tuple[str, Severity]] = []
        for robot, works in self.add(commands, now):
            text = "converges again" if works else "does not converge: a fallback drives"
            found.append((f"robot {robot}: its solver {text}", "info" if works else "error"))
        for robot, reason in self.broken(commands):
            found.append((f"robot {robot} stands still and publishes no plan until a reset: {reason}", "error"))
        return found

    def broken(self, commands: Mapping[int, Command]) -> list[tuple[int, str]]:
        """Robots whose controller, a user's own, has failed for good at this tick, with the reason."""
        found = [(i, command.failure) for i, command in commands.items() if command.failure and i not in self._broken]
        self._broken.update(robot for robot, _ in found)
        return found

    def add(self, commands: Mapping[int, Command], now: float) -> list[tuple[int, bool]]:
        """Count the plans of a tick; robots whose solver began to fail (False) or works again (True).

        Args:
            commands: of the tick, by robot.
            now: simulated time [s].
        """
        changes = []
        for robot, command in commands.items():
            if not command.planned:
                continue
            self.plans[robot] = self.plans.get(robot, 0) + 1
            if not command.converged:
                self.failures[robot] = self.failures.get(robot, 0) + 1
                if robot not in self._failed_at:
                    changes.append((robot, False))
                self._failed_at[robot] = now
            elif robot in self._failed_at and now - self._failed_at[robot] >= RECOVERED_SECONDS - 1e-9:
                del self._failed_at[robot]
                changes.append((robot, True))
        return changes

    def share(self, robot: int) -> float | None:
        """Share of a robot's plans whose solver converged; None before the first plan."""
        plans = self.plans.get(robot, 0)
        return 1.0 - self.failures.get(robot, 0) / plans if plans else None
