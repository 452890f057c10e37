"""Who may publish what, as Zenoh's access control: made of the table of topics, and enforced by the router.

A process is known by the common name of its certificate. Publishing is bound to a role and its number, hearing is free
inside the run, and what is not allowed is denied. Access control cannot be changed while a router runs, but scenarios
can: so there are rules for the first `MAX_KEYED` robots, and whether somebody gets the certificate of one is
decided when it is signed. Whoever opens the unix socket is the user of this machine, who may do everything.
"""

from typing import Any

from network import topics
from network.access.keys import ENCRYPTED, LOCAL, common_name
from network.topics import ALIVE, ASKERS, TOPICS, Role

NUMBERED: tuple[Role, ...] = ("agent", "body")
"""Roles of which there is one process per robot."""
MAX_KEYED = 64
"""Robots whose agents and bodies can have keys: a router that has rules for a thousand starts a second later."""
SINGLE: tuple[Role, ...] = (
    "world",
    "ghost",
    "dashboard",
    "recorder",
    "launcher",
    "keeper",
    "display",
    "operator",
    "observer",
)
_DELIVERED = [
    "put",
    "query",
    "reply",
    "declare_subscriber",
    "declare_queryable",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
]
_HEARD = ["declare_subscriber", "liveliness_query", "declare_liveliness_subscriber"]


def access_list(run: str) -> dict[str, Any]:
    """Zenoh's `access_control` for the router of a run."""
    everything = f"{topics.ROOT}/{run}/**"
    rules = [
        _rule("local", [*_DELIVERED, "delete"], ["**"], "egress", "ingress"),
        _rule("deliver", _DELIVERED, [everything], "egress"),
        _rule("hear", _HEARD, [everything], "ingress"),
        _rule("question", ["query"], [topics.question(run)], "ingress"),
    ]
    subjects: list[dict[str, Any]] = [
        {"id": "local", "link_protocols": [LOCAL]},
        {"id": "remote", "link_protocols": list(ENCRYPTED)},
    ]
    policies = [
        {"rules": ["local"], "subjects": ["local"]},
        {"rules": ["deliver", "hear", "question"], "subjects": ["remote"]},
    ]
    for role, number in members():
        name = common_name(role, number)
        own = _own(run, role, number)
        rules += [_rule(f"{name} {kind}", messages, keys, "ingress") for kind, (messages, keys) in own.items()]
        subjects.append({"id": name, "link_protocols": list(ENCRYPTED), "cert_common_names": [name]})
        if own:
            policies.append({"rules": [f"{name} {kind}" for kind in own], "subjects": [name]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def members() -> list[tuple[Role, int]]:
    """Every role that a certificate may be for, with its number (0: it has none)."""
    robots = range(1, MAX_KEYED + 1)
    return [*((role, 0) for role in SINGLE), *((role, robot) for role in NUMBERED for robot in robots)]


def _own(run: str, role: Role, number: int) -> dict[str, tuple[list[str], list[str]]]:
    """What this role alone may do: kind of rule -> messages and keys."""
    published = [topic.key(run, number or "*") for topic in TOPICS if topic.sender == role and topic.published]
    answered = [topic.key(run) for topic in TOPICS if topic.sender == role and not topic.published]
    found = {
        "publishes": (["put"], published),
        "answers": (["declare_queryable", "reply"], answered),
        "orders": (["query"], [topics.control(run)] if role in ASKERS else []),
        "appears": (["liveliness_token"], [ALIVE.key(run, "*" if role == "keeper" else number, role)]),
    }
    return {kind: (messages, keys) for kind, (messages, keys) in found.items() if keys}


def _rule(name: str, messages: list[str], keys: list[str], *flows: str) -> dict[str, Any]:
    return {"id": name, "messages": messages, "flows": list(flows), "permission": "allow", "key_exprs": keys}
