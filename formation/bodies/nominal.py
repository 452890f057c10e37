"""The bodies in ticks, with [noise] merged in: what agents may know of them, and what the world draws from."""

import math
from dataclasses import dataclass

from formation.bodies.spec import Bodies

MAX_DELAY = 1000
"""Ticks from a command to its effect: an agent remembers little more of what it has commanded."""


@dataclass(frozen=True, slots=True)
class Nominal:
    """Of [bodies], what everybody may know: rates, standard deviations, nominal lag and delay."""

    lag: float
    """Time constant of the wheels [s]."""
    acceleration: float
    """[m/s2]; inf if unlimited."""
    turn_acceleration: float
    """[rad/s2]; inf if unlimited."""
    delay: int
    """Ticks from a command to its effect."""
    slip: float
    gyro: float
    """[rad/s]."""
    correlated: bool
    """Whether slip has a correlation time."""
    period: int
    """Ticks from one localisation to the next."""
    age: int
    """Ticks from a localisation's stamp to its arrival."""
    position: float
    """[m]."""
    heading: float
    """[rad]."""
    relative: float | None
    """Standard deviation of relative sensing [m]; None if robots do not see each other."""
    drawn: bool
    """Whether scales or offsets differ from robot to robot."""

    @property
    def noisy(self) -> bool:
        """Whether anything of what is measured or moved is not exact."""
        return max(self.slip, self.gyro, self.position, self.heading) > 0.0

    @property
    def exact(self) -> bool:
        """Whether a robot moves as its odometry says and its localisation is right."""
        return not (self.noisy or self.drawn)


def ticks_late(key: str, delay: float, dt: float) -> int:
    """How many ticks of dt [s] lie between a command and its effect, of a key that says so in seconds.

    Raises:
        ValueError: they are more than MAX_DELAY.
    """
    if delay / dt > MAX_DELAY + 1e-6:
        raise ValueError(f"{key}: expected at most {MAX_DELAY * dt:g} s at this control_interval; got {delay:g}")
    return round(delay / dt)


def nominal(bodies: Bodies, dt: float) -> Nominal:
    """The nominal body at this control interval [s].

    Raises:
        ValueError: a rate is higher than one measurement a tick, or commands act too late.
    """
    sensor = bodies.localisation
    period = 1.0 if sensor.rate is None else 1.0 / (sensor.rate * dt)
    if period < 1.0 - 1e-9:
        raise ValueError(f"bodies.localisation.rate: expected at most {1.0 / dt:g} a second; got {sensor.rate:g}")
    return Nominal(
        bodies.lag,
        bodies.acceleration or math.inf,
        bodies.turn_acceleration or math.inf,
        ticks_late("bodies.delay", bodies.delay, dt),
        bodies.slip,
        bodies.gyro,
        bodies.slip_time > 0.0,
        max(1, round(period)),
        round(sensor.age / dt),
        sensor.position,
        sensor.heading,
        bodies.relative.sigma,
        max(bodies.scale, bodies.turn_scale, bodies.turn_offset) > 0.0,
    )
