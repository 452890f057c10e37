"""The base of everything that is read from a scenario file: frozen, strict about unknown keys."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat, GetJsonSchemaHandler, ValidationError

from formation.errors import EchelonError
from formation.units import SECONDS, SHARE, seconds, share
from formation.validation import problems

MAX_SCENARIO = 4 << 20
"""Bytes of a scenario, points included: as JSON it goes to every process."""
MAX_ROBOTS = 1024
"""Of a formation."""


class Model(BaseModel):
    """A frozen value that refuses keys it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, use_attribute_docstrings=True)

    def __eq__(self, other: object) -> bool:
        """Same type and same values; what was cached on the way does not count."""
        return isinstance(other, Model) and type(self) is type(other) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]


UNIT = "x-unit"
"""Where a JSON schema has the unit of a key whose docstring need not name it."""


@dataclass(frozen=True, slots=True)
class Written:
    """Of a number that may also be written as text: what a schema has to know of it."""

    unit: str
    pattern: str

    def __get_pydantic_json_schema__(self, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Either the number or its text."""
        return {"anyOf": [handler(core), {"type": "string", "pattern": self.pattern}], UNIT: self.unit}


LARGEST = 1e9
"""Of any size, time or weight: beyond it numbers only overflow."""
Positive = Annotated[FiniteFloat, Field(gt=0.0, le=LARGEST)]
NonNegative = Annotated[FiniteFloat, Field(ge=0.0, le=LARGEST)]
Probability = Annotated[FiniteFloat, BeforeValidator(share), Field(ge=0.0, le=1.0), Written("share", SHARE)]
"""A share in 0..1, or text such as "30%"."""
Duration = Annotated[FiniteFloat, BeforeValidator(seconds), Field(ge=0.0, le=LARGEST), Written("s", SECONDS)]
"""Seconds, or text such as "300ms"."""


class _Seconds(Model):
    """A time by itself."""

    seconds: Duration


def time_of(name: str, value: object) -> float:
    """A time [s], of a number or of text such as "2s". Raises EchelonError: it is none, below 0, or not finite."""
    try:
        return _Seconds.model_validate({"seconds": value}).seconds
    except ValidationError as error:
        raise EchelonError(f"{name}: {problems(error, _Seconds)[0].partition(': ')[2]}") from None


def next_of(times: Iterable[float | None], now: float) -> float:
    """The first of these times that is still to come [s], less what rounding may be off; inf if none is."""
    return min((time - 1e-9 for time in times if time is not None and now < time - 1e-9), default=math.inf)
