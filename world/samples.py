"""What agents and a recorder publish, checked: a Command or a Status is of this episode, from one of its robots."""

from formation.errors import WireError
from network import topics
from network.codec import decode
from network.messages import Command, Status
from network.stretch import Recording
from world.world import World

MAX_AHEAD = 1.0
"""A message may be stamped this far ahead of the world's time [s]."""


def message_of(world: World, key: str, payload: bytes) -> Command | Status | Recording | None:
    """The message; None if it is from an agent that has not yet heard of this episode.

    Raises:
        WireError: it is none, or not one that an agent of this run can send now.
    """
    if key.endswith("/recording"):
        return decode(Recording, payload)
    message = decode(Command, payload) if key.endswith("/command") else decode(Status, payload)
    if message.sender != topics.robot_of(key):
        raise WireError(f"expected the sender named in the key; got {message.sender}")
    if message.episode != world.episode:
        return None
    if message.sender not in world.robots:
        raise WireError(f"expected a robot of the scenario, 1 to {world.scenario.size}; got {message.sender}")
    if message.stamp > world.now + MAX_AHEAD:
        raise WireError(f"expected a stamp up to {world.now:g} s; got {message.stamp:g} s")
    return message
