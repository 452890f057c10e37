"""When a plan goes out: always, or only where its receivers would be wrong (docs/theory.md, section 10).

Between two plans a receiver carries the last one forward, so a plan that only repeats this forecast can stay at home.
"""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.drifting import age_drifting
from network.codec import encode
from network.messages import Command, Plan
from network.values import Motion

QUIET = 0.5
"""A plan goes out at least this often [s], so that silence can be told from a link that is cut."""
WAITED = 0.001
"""While the plan knows of a robot that needs the formation to wait for more than this [s], every plan goes out."""


class Answer(NamedTuple):
    """What an agent publishes at a tick."""

    command: Command
    plan: Plan | None
    """For its neighbours, on a planning tick."""


class Sending:
    """Decides for one robot, from plan to plan, and numbers what goes out."""

    def __init__(self, tolerance: float | None, spacing: float) -> None:
        """Before the first plan.

        Args:
            tolerance: by how much receivers may be wrong about the robot's place [m]; None: every plan goes out.
            spacing: of the formation [m]; an error of the heading counts by what it makes of this length.
        """
        self._tolerance, self._spacing = tolerance, spacing
        self._sent: Plan | None = None

    @property
    def last(self) -> Plan | None:
        """The newest plan that went out."""
        return self._sent

    @property
    def motion(self) -> Motion | None:
        """What it says of the robot's way."""
        sent = self._sent
        return Motion(sent.begins, sent.pose, sent.interval, sent.inputs) if sent else None

    @property
    def size(self) -> int:
        """Of its message [bytes]; 0 before the first."""
        return len(encode(self._sent)) if self._sent else 0

    @property
    def next(self) -> int:
        """Number of the next plan that goes out."""
        return 0 if self._sent is None else self._sent.number + 1

    def offer(self, plan: Plan) -> Plan | None:
        """The plan, if it is to go out; its number is `next`."""
        sent = self._sent
        if sent is not None and self._tolerance is not None and not self._is_news(plan, sent, self._tolerance):
            return None
        self._sent = plan
        return plan

    def _is_news(self, plan: Plan, sent: Plan, tolerance: float) -> bool:
        if plan.stamp - sent.stamp > QUIET - 1e-9 or (plan.waits, plan.lost) != (sent.waits, sent.lost):
            return True
        if _need(plan) > WAITED or _need(sent) > WAITED:  # how much changes from plan to plan
            return True
        forecast = np.empty(3)
        elapsed = plan.begins - sent.begins
        age_drifting(sent.pose, sent.inputs, sent.drift, elapsed, sent.interval, forecast)
        x, y, theta = plan.pose - forecast
        turn = math.atan2(math.sin(theta), math.cos(theta))
        return math.hypot(x, y, self._spacing * turn) > tolerance


def _need(plan: Plan) -> float:
    """For how long any robot that the plan knows of needs the others to wait [s]."""
    return float(plan.news[:, 1].max(initial=0.0))
