"""The base of everything that is read from a scenario file: frozen, strict about unknown keys."""

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat

from formation.units import seconds, share

MAX_SCENARIO = 4 << 20
"""Bytes of a scenario, points included: as JSON it goes to every process."""


class Model(BaseModel):
    """A frozen value that refuses keys it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, use_attribute_docstrings=True)

    def __eq__(self, other: object) -> bool:
        """Same type and same values; what was cached on the way does not count."""
        return isinstance(other, Model) and type(self) is type(other) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]


Positive = Annotated[FiniteFloat, Field(gt=0.0)]
NonNegative = Annotated[FiniteFloat, Field(ge=0.0)]
Probability = Annotated[FiniteFloat, BeforeValidator(share), Field(ge=0.0, le=1.0)]
"""A share in 0..1, or text such as "30%"."""
Duration = Annotated[FiniteFloat, BeforeValidator(seconds), Field(ge=0.0)]
"""Seconds, or text such as "300ms"."""
