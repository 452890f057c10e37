"""The way to a point: which order brings the formation's centre nearer to it, ten times a second."""

import math

from formation.driving.law import Centre, Law, Order
from formation.unicycle import wrap

GAIN, TURN_GAIN = 2.0, 2.0
"""Of the speed near the goal, and of the turn towards it [1/s]."""
BRAKE = 0.5
"""Share of the acceleration that is used to stop at the goal."""
SHARE = 0.5
"""Share of the highest speed at which the centre goes."""
ROOM = 2.2
"""A goal inside so many times the tightest circle is not turned to at once."""
AIMED = 0.5
"""Error of the direction below which the centre slows down for the goal [rad]."""
THERE, ABOUT = 0.002, 0.03
"""So near to the goal it has arrived [m]; a formation that turns as its path does, which cannot turn on the spot, once
the goal is also beside it or behind."""


def towards(law: Law, now: Centre, x: float, y: float) -> Order | None:
    """The order that leads to (x, y) [m]; None once the centre is there.

    It turns towards the goal and goes as fast as it may and can still stop, slower the more it has to turn. Where the
    formation turns as its path does, a goal inside the tightest circle is first left behind straight on.
    """
    ahead, left = x - now.x, y - now.y
    distance = math.hypot(ahead, left)
    error = wrap(math.atan2(left, ahead) - now.theta)
    rigid = law.orientation == "path"
    if distance <= THERE or (rigid and distance <= ABOUT and math.cos(error) <= 0.0):
        return None
    speed = min(SHARE * law.speed, math.sqrt(2.0 * BRAKE * law.acceleration * distance), GAIN * distance)
    turn = TURN_GAIN * error
    if not rigid:
        return law.within(speed * max(math.cos(error), 0.0) ** 2, turn)
    cruise = SHARE * law.speed
    radius = ROOM * cruise / min(law.rotation(cruise), law.turn)
    side = math.copysign(radius, error)
    across = math.hypot(ahead + side * math.sin(now.theta), left - side * math.cos(now.theta))
    inside = across < radius and abs(error) > math.asin(min(distance / (2.0 * radius), 1.0))
    return law.within(cruise, 0.0) if inside else law.within(cruise if abs(error) > AIMED else speed, turn)
