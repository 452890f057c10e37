"""Liveliness tokens of rmw_zenoh: who publishes and subscribes to what, and how.

`@ros2_lv/DOMAIN/SESSION/NODE/ENTITY/KIND/ENCLAVE/NAMESPACE/NODE NAME`, of a publisher (MP) and a subscription (MS)
followed by `/TOPIC/TYPE/HASH/QOS`; a slash in a name is written %.
"""

from typing import Literal, NamedTuple, get_args

from network.fields import harmless
from ros.types import dds_name, kind_of

ALL = "@ros2_lv/**"
Kind = Literal["MP", "MS"]
"""A publisher, a subscription."""
DEFAULT_QOS = "::,10:,:,:,,"
"""Reliable, volatile, keep the last ten."""
_NODE_PARTS, _PARTS = 9, 13


class Endpoint(NamedTuple):
    """A publisher or a subscription."""

    domain: int
    kind: Kind
    namespace: str
    """Of its node, such as "/robot2"; "/" for none."""
    node: str
    topic: str
    """Whole, such as "/robot2/cmd_vel"."""
    type: str
    """Such as "geometry_msgs/Twist"."""
    hash: str
    qos: str
    """As it is in the token."""

    @property
    def key(self) -> str:
        """Where its messages are."""
        return f"{self.domain}/{self.topic.lstrip('/')}/{dds_name(self.type)}/{self.hash}"

    @property
    def any_hash(self) -> str:
        """The same of whatever distribution."""
        return f"{self.domain}/{self.topic.lstrip('/')}/{dds_name(self.type)}/*"

    @property
    def quality(self) -> str:
        """Its QoS in words."""
        reliability, durability, history = (*self.qos.split(":"), "", "", "")[:3]
        kind, _, depth = history.partition(",")
        words = [
            "best effort" if reliability == "2" else "reliable",
            "transient local" if durability == "1" else "volatile",
            "keep all" if kind == "2" else f"keep last {depth or 1}",
        ]
        return ", ".join(words)


def read(token: str) -> Endpoint | None:
    """The endpoint of a token; None if it is of something else."""
    parts = harmless(token).split("/")
    if len(parts) != _PARTS or parts[0] != "@ros2_lv" or not parts[1].isdecimal() or parts[5] not in get_args(Kind):
        return None
    namespace, node, topic = (_name(part) for part in (parts[7], parts[8], parts[9]))
    kind: Kind = "MP" if parts[5] == "MP" else "MS"
    return Endpoint(int(parts[1]), kind, namespace or "/", node, topic, kind_of(parts[10]), parts[11], parts[12])


def node_token(domain: int, session: str, node: str) -> str:
    """Of a node of ours, the first one of its session."""
    return f"@ros2_lv/{domain}/{session}/0/0/NN/%/%/{node}"


def write(endpoint: Endpoint, session: str, entity: int) -> str:
    """The token of an endpoint of a node of ours; `entity` is its number in the session, from 1."""
    return (
        f"@ros2_lv/{endpoint.domain}/{session}/0/{entity}/{endpoint.kind}/%/{_mangled(endpoint.namespace)}/{endpoint.node}/"
        f"{_mangled(endpoint.topic)}/{dds_name(endpoint.type)}/{endpoint.hash}/{endpoint.qos}"
    )


def _mangled(name: str) -> str:
    return name.replace("/", "%")


def _name(part: str) -> str:
    return part.replace("%", "/")
