"""The options of each controller, as the [controller] table of a scenario has them: a union by `name`."""

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from formation.schema import Model, NonNegative, Positive


class ControllerOptions(Model):
    """What every controller has."""

    name: str
    """Which controller."""
    horizon: Annotated[int, Field(ge=2, le=100)] = 20
    """N [prediction intervals]."""
    prediction_interval: Positive = 0.1
    """Delta_T [s]; a whole number of control intervals."""
    plan_every: Annotated[int, Field(ge=1, le=100)] = 1
    """Ticks from one plan to the next; in between the plan's own inputs are applied."""
    age_plans: bool | None = None
    """Roll a received plan forward to now, or use it as if it were fresh; the controller's own way by default."""


SHARED_KEYS = tuple(key for key in ControllerOptions.model_fields if key != "name")
"""Keys that fit every controller."""


class Weighted(ControllerOptions):
    """A controller that minimises a quadratic cost."""

    states: ClassVar[int]
    """Length of the diagonal of Q."""
    q: list[NonNegative] | None = None
    """Diagonal of Q; derived from the scenario if absent."""
    r: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None
    """Diagonal of R: v, omega; derived from the scenario if absent."""

    @model_validator(mode="after")
    def _sized(self) -> Self:
        if self.q is not None and len(self.q) != self.states:
            raise ValueError(f"expected {self.states} values in q for {self.name}; got {len(self.q)}")
        return self


class PairGame(Weighted):
    """A controller that minimises the costs of the pairs of the ring."""

    states = 6
    q: list[NonNegative] | None = None
    """Diagonal of Q: centre, centre, mean heading, radial, tangential, half-difference of headings."""
    formation: Positive = 0.3
    """Weight of the pattern relative to the path; all other weights are derived from the spacing. A larger value
    holds the pattern tighter and makes it depend more on fresh messages."""
    waits: bool = True
    """Whether a robot waits for those that cannot keep up."""


class NashOptions(PairGame):
    """Each robot computes the equilibrium of its pair's game and applies its own part."""

    name: Literal["nash"] = "nash"


class CentralisedOptions(PairGame):
    """One solver with the true poses of all robots minimises the sum of the pairs' costs."""

    name: Literal["centralised"] = "centralised"


class PaperOptions(Weighted):
    """The algorithm of the paper as printed."""

    states = 5
    name: Literal["paper"] = "paper"
    q: list[NonNegative] | None = None
    """Diagonal of Q: x_e, y_e, theta_e, l_e, psi_e."""
    errata: tuple[Literal[1, 2, 3, 4, 5, 14], ...] = ()
    """Errata of the algorithm that are corrected; none by default."""
    misprints: tuple[Literal[6, 7], ...] = ()
    """Errata that are brought back, without which the tests' data follow from the offsets: 6, the virtual centre of
    the triangle; 7, psi_r of the second of two robots."""


class LeaderFollowerOptions(ControllerOptions):
    """The paper's baseline: robot 1 leads with `nash`, every other robot follows its upstream neighbour."""

    name: Literal["leader_follower"] = "leader_follower"
    gains: tuple[Positive, Positive] = (0.1, 0.1)
    """k_x and k_theta of the followers."""
    waits: bool = True
    """Whether the leader waits when it cannot keep up itself."""
    errata: tuple[Literal[13], ...] = ()
    """Errata of the followers' law that are corrected; none by default."""
    misprints: tuple[Literal[11], ...] = ()
    """Errata of the followers' law that are brought back."""


class VirtualStructureOptions(Weighted):
    """Every robot follows its own slot of a moving rigid body and uses no message."""

    states = 3
    name: Literal["virtual_structure"] = "virtual_structure"
    q: list[NonNegative] | None = None
    """Diagonal of Q: x, y, heading."""


class ConsensusOptions(ControllerOptions):
    """Displacement-based formation control of hand points; its gains follow from the limits."""

    name: Literal["consensus"] = "consensus"
