"""How the centre of a driven formation answers to an order: limits, ramps, and which way the formation faces.

One step a tick, in plain floats: the world and robot 1 take the same steps, to the last bit.
"""

import math
from typing import Literal, NamedTuple

from formation.formation_spec import Formation
from formation.paths.driven import Driven
from formation.unicycle import step, wrap

MARGIN = 0.95
"""Share of a robot's limit of speed that orders may use, at the slot that moves fastest."""
TURN_SHARE = 0.4
"""Rotation moves no slot faster than this share of the centre's speed: slots keep going forwards."""
SLOW = 0.05
"""Well below this speed the formation rotates ever less: at rest, a slot's heading is the centre's [m/s]."""
MOST_TURN, TURN_LIMIT = 1.0, 0.5
"""The centre turns by at most this rate [rad/s], and by this share of a robot's limit."""
FACING_GAIN = 1.0
"""How fast a formation of limited orientation turns towards the heading [1/s]."""


class Order(NamedTuple):
    """What the centre is to do, until the next order."""

    v: float
    """[m/s]; below 0 is backwards."""
    omega: float
    """[rad/s]."""


REST = Order(0.0, 0.0)


class Centre(NamedTuple):
    """The formation's centre at a tick."""

    x: float
    y: float
    """[m]."""
    theta: float
    """Its heading [rad]."""
    facing: float
    """Which way the formation faces [rad]."""
    v: float
    omega: float
    """Of the centre [m/s, rad/s]."""
    spin: float
    """At which the formation rotates [rad/s]."""


class Law(NamedTuple):
    """Limits of the centre's motion."""

    speed: float
    """Of an order [m/s]."""
    turn: float
    """Of an order [rad/s]."""
    acceleration: float
    """[m/s2]."""
    turn_acceleration: float
    """[rad/s2]."""
    orientation: Literal["path", "fixed", "limited"]
    rate: float
    """Limit of the formation's rotation, besides TURN_SHARE [rad/s]."""
    reach: float
    """Distance of the outermost slot from the centre [m]."""
    tick: float
    """delta_t [s]."""

    def within(self, v: float, omega: float) -> Order:
        """The order within the limits."""
        return Order(_clip(v, self.speed), _clip(omega, self.turn))

    def rotation(self, v: float) -> float:
        """How fast the formation may rotate while its centre moves at v [rad/s]."""
        pace = abs(v)
        return min(TURN_SHARE * pace * pace / ((pace + SLOW) * self.reach), self.rate)

    def next(self, now: Centre, order: Order) -> Centre:
        """A tick later."""
        dt = self.tick
        v = now.v + _clip(order.v - now.v, self.acceleration * dt)
        most, change = self.rotation(v), self.turn_acceleration * dt
        omega = now.omega + _clip(order.omega - now.omega, change)
        if self.orientation == "path":
            omega = _clip(omega, most)
        x, y, theta = step(now.x, now.y, now.theta, 0.5 * (now.v + v), 0.5 * (now.omega + omega), dt)
        if self.orientation == "path":
            return Centre(x, y, theta, theta, v, omega, omega)
        if self.orientation == "fixed":
            return Centre(x, y, theta, now.facing, v, omega, 0.0)
        wish = _clip(FACING_GAIN * wrap(theta - now.facing), most)
        spin = _clip(now.spin + _clip(wish - now.spin, change), most)
        return Centre(x, y, theta, now.facing + 0.5 * (now.spin + spin) * dt, v, omega, spin)


def _clip(value: float, most: float) -> float:
    return min(max(value, -most), most)


def law_of(path: Driven, formation: Formation, v: float, omega: float, reach: float, tick: float) -> Law:
    """The law of a scenario.

    Args:
        path: that is driven.
        formation: says which way it faces.
        v, omega: the most that slots may ask for [m/s, rad/s].
        reach: of the formation [m].
        tick: delta_t [s].
    """
    rate = formation.turn_rate if formation.orientation == "limited" else None
    return Law(
        MARGIN * v / (1.0 + TURN_SHARE),
        min(MOST_TURN, TURN_LIMIT * omega),
        path.acceleration,
        path.turn_acceleration,
        formation.orientation,
        math.inf if rate is None else rate,
        reach,
        tick,
    )


def at_rest(path: Driven, formation: Formation) -> Centre:
    """The centre at t = 0."""
    x, y, theta = path.start
    return Centre(x, y, theta, formation.heading if formation.orientation == "fixed" else theta, 0.0, 0.0, 0.0)
