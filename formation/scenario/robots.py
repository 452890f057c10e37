"""The robots of a scenario: where they start, their limits, their noise."""

from pydantic import FiniteFloat

from formation.bodies.spec import Bodies
from formation.schema import Model, NonNegative, Positive

Triple = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class Limits(Model):
    """Limits of a robot's inputs: |v| <= v, |omega| <= omega."""

    v: Positive = 0.5
    """Largest |v| [m/s]."""
    omega: Positive = 2.0
    """Largest |omega| [rad/s]."""


class StartNoise(Model):
    """Standard deviations of the start poses."""

    position: NonNegative = 0.0
    """Of x and of y [m]."""
    heading: NonNegative = 0.0
    """Of the heading [rad]."""


class Robots(Model):
    """Start poses, start noise and input limits."""

    poses: list[Triple] | None = None
    """Start poses [m, m, rad]; in formation if absent."""
    limits: Limits = Limits()
    start_noise: StartNoise = StartNoise()
    sight: NonNegative = 1.0
    """How far a robot sees other bodies [m]."""
    avoid: bool = False
    """Keep off the bodies in sight, in plans and by a last filter on commands; slots are no faster than lets stop in
    time behind a robot that stops at once."""


class Noise(Model):
    """Noise, which the prediction model leaves out (docs/theory.md, section 9); n is standard normal."""

    slip: NonNegative = 0.0
    """Each tick v and omega are multiplied by 1 + slip n, each with its own n [1]."""
    gyro: NonNegative = 0.0
    """Each tick gyro n is added to omega [rad/s]."""
    position: NonNegative = 0.0
    """Error of the measured x and y [m]."""
    heading: NonNegative = 0.0
    """Error of the measured heading [rad]."""

    def also_in(self, bodies: Bodies) -> list[str]:
        """The keys that are set here and in [bodies]."""
        sensor = bodies.localisation
        there = {"slip": bodies.slip, "gyro": bodies.gyro, "position": sensor.position, "heading": sensor.heading}
        return [key for key, value in there.items() if value and getattr(self, key)]
