"""The [lockstep] table of a scenario."""

from typing import Annotated

from pydantic import Field

from formation.schema import Duration, Model


class Lockstep(Model):
    """How a lockstep run, in which the world waits for every agent, deals with one that does not answer."""

    patience: Annotated[Duration, Field(gt=0.0)] = 30.0
    """An agent that is there but does not answer for this long is no longer waited for, until it answers again
    [s], by the world's own running time."""
