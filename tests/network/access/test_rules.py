"""Laws of the router's access list: whoever does not own a topic publishes nothing on it, whatever keys it shows."""

import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import trustme

from formation.errors import EchelonError
from network import topics
from network.access.keys import AUTHORITY, Keys
from network.bus import Presence, Query, Sample
from network.topics import TOPICS
from network.zenoh_bus import Router, ZenohBus
from runtime.hosts.authority import Authority

RUN = "locked"
ROLES = (
    "world",
    "agent-1",
    "agent-2",
    "body-1",
    "body-2",
    "ghost",
    "display",
    "dashboard",
    "recorder",
    "launcher",
    "keeper",
    "operator",
    "observer",
)
OWNERS = {
    "tick": "world",
    "state": "world",
    "stretch": "world",
    "control": "world",
    "question": "world",
    "body_input": "world",
    "body_pose": "body-1",
    "ghost": "ghost",
    "recording": "recorder",
    "plan": "agent-1",
    "command": "agent-1",
    "status": "agent-1",
}
"""Who may publish or answer; of robot 1's topics the agent of robot 1."""
ORDERS = {"dashboard", "operator"}
PUBLISHED = [topic for topic in TOPICS if topic.name in OWNERS and topic.published]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Locked:
    """A router with a unix socket and an encrypted port, who listens to everything, and a session in each role."""

    def __init__(self, folder: Path) -> None:
        Authority().write(folder, "router", *ROLES)
        self.folder, local = folder, f"unixsock-stream/{folder}/r"
        self.endpoint = f"tls/127.0.0.1:{free_port()}"
        self.router = Router([local, self.endpoint], RUN, keys=Keys.of(folder, "router"))
        self.listener = ZenohBus(local, RUN)
        self.of = {role: ZenohBus(self.endpoint, RUN, keys=Keys.of(folder, role)) for role in ROLES}

    def close(self) -> None:
        for session in (*self.of.values(), self.listener):
            session.close()
        self.router.close()

    def heard(self, enough: Callable[[list[object]], bool]) -> list[object]:
        """What arrives until there is enough of it, and a moment after."""
        found: list[object] = []
        until = time.monotonic() + 10.0
        while time.monotonic() < until and not enough(found):
            found += self.listener.arrivals(0.05)
        return [*found, *self.listener.incoming(0.3)]


@pytest.fixture(scope="module")
def locked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Locked]:
    found = Locked(tmp_path_factory.mktemp("k"))
    yield found
    found.close()


def test_the_table_of_owners_has_every_topic() -> None:
    assert set(OWNERS) | {"alive"} == {topic.name for topic in TOPICS}


def test_what_others_than_the_owner_publish_does_not_arrive_and_what_the_owner_does_does(locked: Locked) -> None:
    locked.listener.subscribe(f"echelon/{RUN}/**")
    keys = {topic.name: topic.key(RUN, 1) for topic in PUBLISHED}
    for role, session in locked.of.items():
        for key in keys.values():
            session.announce(key, reliable=True)
            session._publishers[key].put(role)
    wanted = {(keys[name], OWNERS[name]) for name in keys}
    heard = locked.heard(lambda found: len(found) >= len(wanted))
    assert {(item.key, item.payload.decode()) for item in heard if isinstance(item, Sample)} == wanted
    locked.listener.unsubscribe(f"echelon/{RUN}/**")


def test_everybody_in_the_run_hears_everything(locked: Locked) -> None:
    key = topics.plan(RUN, 1)
    for session in locked.of.values():
        session.subscribe(key)
    time.sleep(0.3)
    locked.of["agent-1"].announce(key, reliable=True)
    locked.of["agent-1"]._publishers[key].put("plan")
    for role, session in locked.of.items():
        assert any(isinstance(item, Sample) for item in session.incoming(5.0)), role
        session.unsubscribe(key)


def test_orders_are_for_few_questions_for_all_and_answers_are_the_worlds(locked: Locked) -> None:
    for role in ROLES:
        locked.of[role].serve(topics.control(RUN))  # all but the world's are denied
        locked.of[role].serve(topics.question(RUN))
    time.sleep(0.3)
    for key, allowed in ((topics.control(RUN), ORDERS), (topics.question(RUN), set(ROLES))):
        for role in ROLES:
            if role == "world":
                continue  # it would answer itself
            for session in locked.of.values():
                session.arrivals()
            list(locked.of[role]._session.get(key, payload=role, timeout=0.1))
            wait = 5.0 if role in allowed else 0.0  # what must come is waited for; what must not has had as long
            asked = {"world" for item in locked.of["world"].arrivals(wait) if isinstance(item, Query)}
            asked |= {
                who
                for who, session in locked.of.items()
                for item in session.arrivals()
                if isinstance(item, Query) and item.payload.decode() == role
            }
            # A session hears its own question at once: that passes no router.
            assert asked - {role} == ({"world"} if role in allowed else set()), (key, role)


def test_nobody_appears_as_somebody_else(locked: Locked) -> None:
    for session in locked.of.values():
        for role in ROLES:
            name, _, number = role.partition("-")
            session.appear(name, int(number or 0))
    locked.listener.watch()
    time.sleep(0.3)
    heard = locked.heard(lambda found: len(found) > len(ROLES))
    seen = [(item.role, item.number) for item in heard if isinstance(item, Presence)]
    assert sorted(seen) == sorted((role.partition("-")[0], int(role.partition("-")[2] or 0)) for role in ROLES)
    locked.of["agent-2"].close()  # each token was its owner's: it goes with it
    gone = [item for item in locked.heard(bool) if isinstance(item, Presence)]
    assert gone == [Presence("agent", 2, here=False)]


@pytest.mark.parametrize("who", ["another authority", "nobody", "an agent as the router"])
def test_strangers_are_refused_with_a_clear_word(locked: Locked, tmp_path: Path, who: str) -> None:
    if who == "nobody":
        with pytest.raises(EchelonError, match="expected keys for tls"):
            ZenohBus(locked.endpoint, RUN)
        with pytest.raises(EchelonError, match="--insecure"):
            ZenohBus(locked.endpoint.replace("tls/", "tcp/"), RUN)
        return
    other = trustme.CA()
    (tmp_path / AUTHORITY).write_bytes((locked.folder / AUTHORITY).read_bytes())
    if who == "another authority":
        certificate = other.issue_cert("world", common_name="world")
        (tmp_path / "world.pem").write_bytes(certificate.cert_chain_pems[0].bytes())
        (tmp_path / "world.key").write_bytes(certificate.private_key_pem.bytes())
        begun = time.monotonic()
        with pytest.raises(EchelonError, match="refuses these keys: they are of another run"):
            ZenohBus(locked.endpoint, RUN, keys=Keys.of(tmp_path, "world"))
        assert time.monotonic() - begun < 5.0
        other.cert_pem.write_to_path(str(tmp_path / AUTHORITY))
        with pytest.raises(EchelonError, match="is not the router of the run that these keys are for"):
            ZenohBus(locked.endpoint, RUN, keys=Keys.of(tmp_path, "world"))
        return
    endpoint = f"tls/127.0.0.1:{free_port()}"
    false = Router([endpoint], RUN, keys=Keys.of(locked.folder, "agent-2"))
    with pytest.raises(EchelonError, match="is not the router"):
        ZenohBus(endpoint, RUN, keys=Keys.of(locked.folder, "agent-1"))
    false.close()
