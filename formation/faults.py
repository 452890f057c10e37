"""The fault model of a link: its parameters, presets, and how they are shown.

network/link.py applies a fault to messages; world/faults.py decides which fault is active at which tick.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from formation.errors import FaultError, unknown
from formation.schema import Duration, Model, NonNegative, Probability
from formation.validation import problems


@dataclass(frozen=True, slots=True)
class Shown:
    """How a key of a fault is written and set: its label, unit and range are here and nowhere else."""

    phrase: str
    """In a sentence, with {} for the value in `unit`."""
    label: str = ""
    """Of its slider."""
    unit: str = ""
    factor: float = 1.0
    """From the fault's own unit to `unit`."""
    top: float = 0.0
    """Largest value of a slider, which begins at 0 [unit]; 0 if there is none."""
    step: float = 1.0
    """Of a slider [unit]."""
    often: bool = False
    """Whether it is among the keys that are offered first."""
    argument: str = "N"
    """What a command's help calls the value."""

    def words(self, value: object) -> str:
        """The key and its value."""
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return self.phrase.format(f"{self.shown(value):.4g}" if number else value)  # type: ignore[arg-type]

    def shown(self, value: float) -> float:
        """The value in `unit`."""
        return value * self.factor


class Fault(Model):
    """Everything that a directed link does to messages; the default is a perfect link."""

    latency: Annotated[
        Duration, Shown("latency {} ms", "Latency", "ms", 1e3, 1000.0, 10.0, often=True, argument="TIME")
    ] = 0.0
    """Delay of every message, such as 300ms [s]."""
    jitter: Annotated[Duration, Shown("jitter {} ms", "Jitter", "ms", 1e3, 300.0, 5.0, often=True, argument="TIME")] = (
        0.0
    )
    """Spread of the delay [s]: half width (uniform), standard deviation (normal), mean of the tail (pareto)."""
    distribution: Annotated[Literal["uniform", "normal", "pareto"], Shown("({})", argument="NAME")] = "uniform"
    """Shape of the jitter: uniform, normal or pareto; no delay is ever below zero."""
    loss: Annotated[Probability, Shown("loss {} %", "Loss", "%", 1e2, 100.0, 1.0, often=True, argument="SHARE")] = 0.0
    """Mean share of messages lost, such as 30%."""
    burst: Annotated[NonNegative, Shown("bursts of {}", "Burst length", "", 1.0, 50.0, 1.0, often=True)] = 0.0
    """Mean number of messages lost in a row (Gilbert-Elliott) [messages]; up to 1 / (1 - loss) losses are
    independent."""
    duplicate: Annotated[Probability, Shown("duplicates {} %", "Duplicate", "%", 1e2, 100.0, 1.0, argument="SHARE")] = (
        0.0
    )
    """Share of messages that arrive twice, each copy with its own jitter."""
    reorder: Annotated[Probability, Shown("reorders {} %", "Reorder", "%", 1e2, 100.0, 1.0, argument="SHARE")] = 0.0
    """Share of messages that overtake: they skip the delay, as in netem."""
    keep_order: Annotated[bool, Shown("in order")] = False
    """Hold a message back until those sent before it have arrived."""
    rate: Annotated[NonNegative, Shown("at most {}/s", "At most", "/s", 1.0, 200.0, 5.0)] = 0.0
    """Messages that pass [messages/s]; a few of the others queue, the rest is lost; 0 means no limit."""
    corrupt: Annotated[Probability, Shown("corrupts {} %", "Corrupt", "%", 1e2, 100.0, 1.0, argument="SHARE")] = 0.0
    """Share of messages with flipped bytes."""
    cut: Annotated[bool, Shown("cut")] = False
    """No message passes."""

    def plain(self) -> dict[str, Any]:
        """The keys that differ from a perfect link's."""
        return {key: value for key, value in self.model_dump().items() if value != Fault.model_fields[key].default}

    def words(self) -> str:
        """A short description for the user."""
        if self.cut:
            return SHOWN["cut"].phrase
        words = ", ".join(SHOWN[key].words(value) for key, value in self.plain().items()) or "healthy"
        return words.replace(", (", " (")  # jitter and its distribution


SHOWN: Mapping[str, Shown] = {
    key: next(item for item in field.metadata if isinstance(item, Shown)) for key, field in Fault.model_fields.items()
}
"""How each key of a fault is written and set."""

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
    """A directed link such as "1->2" (plans), "world->1" (poses) or "1->world" (commands); "all" means every link
    between robots."""
    preset: Annotated[str, Field(json_schema_extra={"enum": list(PRESETS)})] | None = None
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
