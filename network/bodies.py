"""Between the world and the process of a real robot's body: what the robot is to do, and where it is."""

from dataclasses import dataclass

from network.fields import STRICT, Count, NonNegative, Pose, Real, Sender, Velocity


@dataclass(frozen=True, slots=True)
class BodyInput:
    """World to the body of a real robot: the input that it acts on now, past its link and the watchdog."""

    sender: Sender
    seq: Count
    """k of the tick that ended with it."""
    stamp: NonNegative
    episode: Count
    v: Real
    """[m/s]."""
    omega: Real
    """[rad/s]."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True, eq=False)
class BodyPose:
    """Body of a real robot to the world: where it is. It is silent while it does not know."""

    sender: Sender
    seq: Count
    """Number of the pose."""
    stamp: NonNegative
    """Of the newest BodyInput that it has."""
    episode: Count
    """Likewise."""
    pose: Pose
    """[m, m, rad], in the formation's map."""
    velocity: Velocity
    """v, omega in the robot's frame: measured, or commanded if nobody measures them [m/s, rad/s]."""
    age: NonNegative
    """Since it came in from the robot [s of wall clock]."""
    __pydantic_config__ = STRICT
