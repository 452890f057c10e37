"""The fault model of a link: its parameters, presets, link names.

network/link.py applies a fault to messages; world/faults.py decides which fault is active at which tick.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any, Literal

from pydantic import ValidationError, model_validator

from formation.errors import FaultError, unknown
from formation.pattern import downstream
from formation.schema import Duration, Model, NonNegative, Probability
from formation.validation import problems


class Fault(Model):
    """Everything that a directed link does to messages; the default is a perfect link."""

    latency: Duration = 0.0
    """Delay of every message [s]."""
    jitter: Duration = 0.0
    """Spread of the delay [s]: half width (uniform), standard deviation (normal), mean of the tail (pareto)."""
    distribution: Literal["uniform", "normal", "pareto"] = "uniform"
    """Shape of the jitter; no delay is ever below zero."""
    loss: Probability = 0.0
    """Mean share of messages lost."""
    burst: NonNegative = 0.0
    """Mean number of messages lost in a row (Gilbert-Elliott); up to 1 / (1 - loss) losses are independent."""
    duplicate: Probability = 0.0
    """Share of messages that arrive twice, each copy with its own jitter."""
    reorder: Probability = 0.0
    """Share of messages that overtake: they skip the delay, as in netem."""
    keep_order: bool = False
    """Hold a message back until those sent before it have arrived."""
    rate: NonNegative = 0.0
    """Messages a second that pass, the others queue (at most QUEUE_LIMIT) or are lost; 0 means no limit."""
    corrupt: Probability = 0.0
    """Share of messages with flipped bytes."""
    cut: bool = False
    """No message passes."""

    def plain(self) -> dict[str, Any]:
        """The keys that differ from a perfect link's."""
        return {key: value for key, value in self.model_dump().items() if value != Fault.model_fields[key].default}

    def words(self) -> str:
        """A short description for the user."""
        if self.cut:
            return "cut"
        return ", ".join(_WORDS[key](value) for key, value in self.plain().items()) or "healthy"


_WORDS: Mapping[str, Callable[[Any], str]] = {
    "latency": lambda v: f"latency {v * 1e3:g} ms",
    "jitter": lambda v: f"jitter {v * 1e3:g} ms",
    "distribution": lambda v: f"({v})",
    "loss": lambda v: f"loss {v * 100:g} %",
    "burst": lambda v: f"bursts of {v:g}",
    "duplicate": lambda v: f"duplicates {v * 100:g} %",
    "reorder": lambda v: f"reorders {v * 100:g} %",
    "keep_order": lambda _: "in order",
    "rate": lambda v: f"at most {v:g}/s",
    "corrupt": lambda v: f"corrupts {v * 100:g} %",
}

PERFECT = Fault()
"""A link without faults."""

PRESETS: Mapping[str, Fault] = {
    "wifi": Fault(latency=0.02, jitter=0.01, loss=0.005, duplicate=0.001),
    "congested": Fault(latency=0.15, jitter=0.1, distribution="pareto", loss=0.05, burst=3, rate=50),
    "satellite": Fault(latency=0.6, jitter=0.02, distribution="normal", loss=0.01),
    "bursty": Fault(latency=0.03, jitter=0.02, distribution="normal", loss=0.3, burst=12, reorder=0.02),
    "blackout": Fault(cut=True),
}


class ScheduledFault(Fault):
    """A fault that a scenario switches on and off by itself; only the keys it names are changed."""

    at: Duration = 0.0
    """Simulated time at which it begins [s]."""
    until: Duration | None = None
    """Simulated time at which it ends [s]; never, if absent."""
    link: str = "all"
    """A directed link such as "2->1", or "all" between robots."""
    preset: str | None = None
    """Start from this preset; keys beside it refine it."""

    @model_validator(mode="after")
    def _sensible(self) -> "ScheduledFault":
        if self.until is not None and self.until <= self.at:
            raise ValueError(f"expected until > at; got until {self.until:g} and at {self.at:g}")
        if self.preset is not None and self.preset not in PRESETS:
            raise ValueError(unknown("preset", self.preset, PRESETS))
        return self

    def changes(self) -> dict[str, Any]:
        """The keys this entry sets on its link."""
        own = {key: getattr(self, key) for key in self.model_fields_set if key in Fault.model_fields}
        return own if self.preset is None else preset(self.preset).model_dump() | own


def preset(name: str) -> Fault:
    """The preset of this name.

    Raises:
        FaultError: there is none; the text lists them.
    """
    if name not in PRESETS:
        raise FaultError(unknown("preset", name, PRESETS))
    return PRESETS[name]


def with_changes(fault: Fault, changes: Mapping[str, Any]) -> Fault:
    """The fault with some keys set anew.

    Raises:
        FaultError: an unknown key or a value out of range; one line per mistake.
    """
    try:
        return Fault.model_validate(fault.model_dump() | dict(changes))
    except ValidationError as error:
        raise FaultError("; ".join(problems(error, Fault))) from None


def plan_links(robots: int) -> list[str]:
    """The ring's directed links, in the order of their receivers' upstream neighbours: "1->2", "2->3", ..."""
    return [f"{i}->{downstream(i, robots)}" for i in range(1, robots + 1)]


def every_link(robots: int) -> list[str]:
    """All links that can be given a fault: the ring, and each robot's poses and commands."""
    own = [name for i in range(1, robots + 1) for name in (f"world->{i}", f"{i}->world")]
    return plan_links(robots) + own


def links_named(name: str, robots: int) -> list[str]:
    """The links that `name` stands for: itself, or the ring's for "all". Spaces and the sign → are accepted.

    Raises:
        FaultError: there is no such link; the text lists them.
    """
    name = re.sub(r"\s*(->|→)\s*", "->", name.strip())
    if name == "all":
        return plan_links(robots)
    if name not in every_link(robots):
        raise FaultError(unknown("link", name, ["all", *every_link(robots)]))
    return [name]
