"""The options of each controller, as the [controller] table of a scenario has them: a union by `name`."""

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from formation.schema import Model, NonNegative, Positive


class ControllerOptions(Model):
    """What every controller has."""

    name: str
    """Which controller."""
    horizon: Annotated[int, Field(ge=2, le=100)] = 20
    """N, the prediction intervals that a plan covers [intervals]."""
    prediction_interval: Positive = 0.1
    """Delta_T, the length of one of them [s]; a whole number of control intervals."""
    plan_every: Annotated[int, Field(ge=1, le=100)] = 1
    """From one plan to the next [ticks]; in between the plan's own inputs are applied."""
    age_plans: bool | None = None
    """Roll a received plan forward to now, or use it as if it were fresh; the controller's own way by default."""

    send_when: Positive | None = None
    """A plan goes out only when the receivers' forecast of the robot's place is wrong by more than this [m], when
    somebody waits, or after 0.5 s; by default every plan goes out."""

    @property
    def uses_sight(self) -> bool:
        """Whether it uses the upstream neighbour's position where bodies have relative sensing."""
        return False

    @property
    def uses_plans(self) -> bool:
        """Whether it uses what its neighbours send; else a neighbour that it sees is silent to it."""
        return True

    @property
    def uses_downstream(self) -> bool:
        """Whether it uses the plans of its downstream neighbour as well."""
        return False


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
    """Weight of the pattern relative to the path [1]; all other weights are derived from the spacing. A larger value
    holds the pattern tighter and makes it depend more on fresh messages."""
    waits: bool = True
    """Whether a robot waits for those that cannot keep up."""


class NashOptions(PairGame):
    """Best response to the neighbours' plans along the edges, or (game = "pair") the equilibrium of the pair's game."""

    name: Literal["nash"] = "nash"
    game: Literal["response", "pair"] = "response"
    """A best response to the neighbours along the edges, or the paper's game with the upstream neighbour."""
    hears: Literal["upstream", "both"] = "upstream"
    """Whose plans a robot receives: the paper's directed ring, or both ring neighbours ("response" only)."""
    own_weight: Positive = 120.0
    """Cost of an error of one spacing from the own slot while no plan is trusted ("response" only)
    [1]."""
    trust_time: Positive | None = None
    """Time constant with which trust in a plan fades with its age [s]; by default 0.3, with both neighbours 0.5."""

    @property
    def uses_sight(self) -> bool:
        return self.game == "response"

    @property
    def uses_downstream(self) -> bool:
        return self.game == "response" and self.hears == "both"

    @model_validator(mode="after")
    def _of_the_game(self) -> Self:
        keys = ("formation", "q") if self.game == "response" else ("hears", "own_weight", "trust_time")
        # A value that is the default was not meant: a whole table with every key is as good as a short one.
        wrong = [key for key in keys if getattr(self, key) != type(self).model_fields[key].default]
        if wrong:
            other = "pair" if self.game == "response" else "response"
            raise ValueError(f"expected {', '.join(wrong)} with game = {other!r} only; got game = {self.game!r}")
        return self


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


class VirtualStructureOptions(ControllerOptions):
    """Every robot follows its own slot of a moving rigid body and uses no message."""

    name: Literal["virtual_structure"] = "virtual_structure"
    own_weight: Positive = 120.0
    """Cost of an error of one spacing from the own slot [1]."""
    r: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None
    """Diagonal of R: v, omega; derived from the scenario if absent."""
    sees: bool = False
    """Whether a robot also holds the edge to the neighbour that it senses, where the bodies have relative sensing."""

    @property
    def uses_sight(self) -> bool:
        return self.sees

    @property
    def uses_plans(self) -> bool:
        return False


class ConsensusOptions(ControllerOptions):
    """Displacement-based formation control of hand points."""

    name: Literal["consensus"] = "consensus"
    gain: Positive | None = None
    """k_g = k_f, to the own slot and to the neighbour [1/s]; follows from the limits if absent."""
