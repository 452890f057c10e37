"""Laws of the wire: what was encoded comes back; whatever else comes in is a WireError."""

# mypy: disable-error-code="no-any-return"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import dataclasses
import struct
import typing
import unicodedata
import zlib
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from formation.errors import WireError
from formation.faults import Fault
from formation.link_ids import every_link
from formation.schema import MAX_ROBOTS
from network import topics
from network.codec import MAX_BYTES, decode, encode, seal, unseal
from network.link import damaged
from network.messages import VERSION, Command, Message, Plan
from network.requests import Reply, Request
from tests import builders
from tests.strategies import PLAIN, TEXT, of
from world.sight import CROWD

KINDS = typing.get_args(Message)
BY_KIND = {kind: of(kind) for kind in KINDS}
ANY_MESSAGE = st.one_of(*BY_KIND.values())

PLAN = builders.plan(2, 17, 3, inputs=np.arange(40.0).reshape(20, 2))
TICK = builders.tick(17, np.arange(9.0).reshape(3, 3), episode=3, revision=1, planned=[1, 2, 3])
COMMAND = builders.command(1, 17)
STATUS = builders.status(1, 2, plan=builders.motion())


def same(a: Any, b: Any) -> bool:
    """Equal to the last bit, field by field."""
    if type(a) is not type(b):
        return False
    if dataclasses.is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return a == b


def body_of(message: Message) -> dict[str, Any]:
    """The map on the wire, to be tampered with."""
    return msgpack.unpackb(unseal(encode(message)))


def sealed(body: object) -> bytes:
    return seal(msgpack.packb(body))


def test_every_message_class_has_one_name_on_the_wire() -> None:
    assert set(topics.MESSAGES.values()) == set(KINDS)
    assert len(topics.MESSAGES) == len(KINDS), "two names for one class"


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_message_comes_back_as_it_was_sent(kind: Any) -> None:
    @settings(max_examples=25)
    @given(BY_KIND[kind])
    def law(message: Any) -> None:
        assert same(decode(kind, encode(message)), message)

    law()


@given(ANY_MESSAGE)
@settings(max_examples=40)
def test_encoding_a_decoded_message_gives_the_same_bytes(message: Any) -> None:
    payload = encode(message)
    assert encode(decode(type(message), payload)) == payload


def test_a_number_that_is_whole_comes_back_as_a_float() -> None:
    command = decode(Command, encode(dataclasses.replace(COMMAND, v=1)))
    assert command.v == 1.0
    assert isinstance(command.v, float)


def test_arrays_that_came_over_the_wire_are_read_only() -> None:
    plan = decode(Plan, encode(PLAN))
    with pytest.raises(ValueError, match="read-only"):
        plan.inputs[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        plan.pose[0] = 1.0


@given(st.sampled_from(KINDS), st.binary(max_size=400))
@settings(max_examples=100)
def test_arbitrary_bytes_are_a_wire_error(kind: Any, payload: Any) -> None:
    with pytest.raises(WireError):
        decode(kind, payload)


@given(st.sampled_from(KINDS), st.binary(max_size=200))
@settings(max_examples=100)
def test_arbitrary_bytes_with_a_valid_checksum_are_a_wire_error(kind: Any, body: Any) -> None:
    with pytest.raises(WireError):
        decode(kind, seal(body))


@given(st.sampled_from(KINDS), PLAIN)
@settings(max_examples=80)
def test_arbitrary_messagepack_is_a_wire_error(kind: Any, value: Any) -> None:
    with pytest.raises(WireError):
        decode(kind, sealed(value))


@given(ANY_MESSAGE, st.data())
@settings(max_examples=100)
def test_a_message_with_one_field_replaced_by_anything_is_a_message_or_a_wire_error(message: Any, data: Any) -> None:
    body = body_of(message)
    field = data.draw(st.sampled_from(sorted(body)))
    body[field] = data.draw(PLAIN | st.binary(max_size=64))
    try:
        again = decode(type(message), sealed(body))
    except WireError as error:
        text = str(error)
        assert len(text) < 500
        assert "\n" not in text
    else:
        assert type(again) is type(message)


@given(ANY_MESSAGE, st.data())
@settings(max_examples=40)
def test_a_truncated_message_is_a_wire_error(message: Any, data: Any) -> None:
    payload = encode(message)
    short = payload[: data.draw(st.integers(0, len(payload) - 1))]
    with pytest.raises(WireError):
        decode(type(message), short)


@given(ANY_MESSAGE, st.data())
@settings(max_examples=60)
def test_a_flipped_bit_is_a_wire_error(message: Any, data: Any) -> None:
    payload = bytearray(encode(message))
    place = data.draw(st.integers(0, 8 * len(payload) - 1))
    payload[place // 8] ^= 1 << place % 8
    with pytest.raises(WireError):
        decode(type(message), bytes(payload))


@given(ANY_MESSAGE, st.floats(0.0, 1.0, exclude_max=True))
@settings(max_examples=60)
def test_what_a_link_damaged_is_a_wire_error(message: Any, damage: Any) -> None:
    with pytest.raises(WireError):
        decode(type(message), damaged(encode(message), damage))


@given(ANY_MESSAGE)
@settings(max_examples=40)
def test_bytes_behind_the_end_are_a_wire_error(message: Any) -> None:
    payload = encode(message)
    with pytest.raises(WireError):
        decode(type(message), payload + b"\x00")
    with pytest.raises(WireError):
        decode(type(message), seal(payload[4:] + b"\x00"))


@given(ANY_MESSAGE, st.sampled_from(KINDS))
@settings(max_examples=40)
def test_a_message_of_another_kind_is_a_wire_error(message: Any, kind: Any) -> None:
    assume(kind is not type(message))
    with pytest.raises(WireError, match="expected a "):
        decode(kind, encode(message))


@pytest.mark.parametrize("version", [0, VERSION + 1, "1", None, -1, 2**40, [1]])
def test_another_version_is_a_wire_error(version: Any) -> None:
    body = body_of(PLAN) | {"version": version}
    with pytest.raises(WireError, match="version"):
        decode(Plan, sealed(body))


@pytest.mark.parametrize("message", [PLAN, TICK, COMMAND, Reply(True)], ids=lambda m: type(m).__name__)
def test_every_missing_required_field_is_a_wire_error_that_names_it(message: Any) -> None:
    body = body_of(message)
    fields = dataclasses.fields(message)
    required = [f.name for f in fields if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING]
    assert required
    for name in required:
        with pytest.raises(WireError, match=name):
            decode(type(message), sealed({key: value for key, value in body.items() if key != name}))


@pytest.mark.parametrize("name", ["type", "version"])
def test_a_message_without_type_or_version_is_a_wire_error(name: Any) -> None:
    body = body_of(PLAN)
    del body[name]
    with pytest.raises(WireError, match=f"expected .*{name}|expected a plan"):
        decode(Plan, sealed(body))


@given(ANY_MESSAGE, TEXT, PLAIN)
@settings(max_examples=40)
def test_an_extra_field_is_a_wire_error(message: Any, name: Any, value: Any) -> None:
    body = body_of(message)
    assume(name not in body)
    with pytest.raises(WireError):
        decode(type(message), sealed(body | {name: value}))


def numbers(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}d", *values)


@pytest.mark.parametrize(
    ("message", "field", "value"),
    [
        (COMMAND, "v", float("nan")),
        (COMMAND, "omega", float("inf")),
        (COMMAND, "age", float("-inf")),
        (COMMAND, "v", 1e300),
        (COMMAND, "solve", 1e300),
        (PLAN, "lag_rate", -1e300),
        (PLAN, "pose", numbers(0.0, -1e300, 0.0)),
        (PLAN, "measurements", numbers(*[0.0] * 8, 1e17)),
        (COMMAND, "stamp", -0.01),
        (COMMAND, "stamp", float("nan")),
        (COMMAND, "v", "0.4"),
        (COMMAND, "v", None),
        (COMMAND, "v", True),
        (COMMAND, "v", [0.4]),
        (COMMAND, "sender", MAX_ROBOTS + 1),
        (COMMAND, "sender", -1),
        (COMMAND, "sender", 1.0),
        (COMMAND, "sender", True),
        (COMMAND, "seq", 0.5),
        (COMMAND, "seq", -1),
        (COMMAND, "seq", 2**63),
        (COMMAND, "episode", "3"),
        (COMMAND, "planned", 1),
        (COMMAND, "planned", "yes"),
        (PLAN, "interval", 0.0),
        (PLAN, "interval", -0.1),
        (PLAN, "pose", numbers(0.0, 0.0)),
        (PLAN, "pose", numbers(*[0.0] * 6)),
        (PLAN, "pose", numbers(0.0, float("nan"), 0.0)),
        (PLAN, "pose", [0.0, 0.0, 0.0]),
        (PLAN, "inputs", b""),
        (PLAN, "inputs", numbers(0.0, 0.0, 0.0)),
        (PLAN, "inputs", numbers(0.0, float("inf"))),
        (PLAN, "inputs", b"\x00" * 15),
        (PLAN, "inputs", None),
        (STATUS, "plan", 3),
        (STATUS, "believes", {"begins": 1.0}),
        (STATUS, "believes", body_of(PLAN)),
        (TICK, "poses", numbers(0.0, 0.0)),
        (TICK, "poses", numbers(0.0, 0.0, float("-inf"))),
        (TICK, "planned", [MAX_ROBOTS + 1]),
        (TICK, "planned", 3),
        (TICK, "planned", ["1"]),
        (Reply(True), "value", [1]),
        (Reply(True), "reason", b"bytes"),
        (Reply(True), "reason", "x" * 70_000),
        (Request("start"), "arguments", {1: 2}),
    ],
)
def test_a_value_of_the_wrong_type_range_or_shape_is_a_wire_error(message: Any, field: Any, value: Any) -> None:
    body = body_of(message)
    assert field in body
    decode(type(message), sealed(body))  # it is this value that is refused
    with pytest.raises(WireError):
        decode(type(message), seal(msgpack.packb(body | {field: value})))


@given(st.text())
def test_no_text_of_a_message_moves_a_terminals_cursor(text: Any) -> None:
    read = decode(Reply, encode(Reply(False, f"\x1b[2J{text}\x9b\r\u202e"))).reason
    assert not [character for character in read if is_control(character) and character not in "\n\t"]
    assert decode(Reply, encode(Reply(False, "two\nlines"))).reason == "two\nlines"


TURNING = ("LRO", "RLO", "LRE", "RLE", "PDF")
"""The direction of what follows."""


def is_control(character: str) -> bool:
    return unicodedata.category(character) == "Cc" or unicodedata.bidirectional(character) in TURNING


def test_a_huge_payload_is_refused_before_it_is_unpacked() -> None:
    body = b"\xdd" + struct.pack(">I", 2**31) + b"\x00" * MAX_BYTES
    payload = seal(body)
    with pytest.raises(WireError, match=str(MAX_BYTES)):
        decode(Plan, payload)


def test_a_short_payload_that_claims_to_be_huge_is_a_wire_error() -> None:
    for claim in (b"\xdd", b"\xdf", b"\xdb", b"\xc6"):  # array32, map32, str32, bin32 of 4 GB
        with pytest.raises(WireError):
            decode(Plan, seal(claim + b"\xff\xff\xff\xff"))


def test_deep_nesting_is_a_wire_error() -> None:
    with pytest.raises(WireError):
        decode(Plan, seal(b"\x91" * 100_000 + b"\xc0"))


def test_the_largest_real_messages_fit_by_far() -> None:
    everybody = list(range(1, MAX_ROBOTS + 1))
    seen = np.zeros((MAX_ROBOTS * (CROWD - 1), 3))
    tick = builders.tick(
        1, np.zeros((MAX_ROBOTS, 3)), planned=everybody, relatives=np.zeros((MAX_ROBOTS, 2)), seen=seen
    )
    state = builders.state(
        MAX_ROBOTS, faults=dict.fromkeys(every_link(MAX_ROBOTS), Fault(latency=0.123456789, loss=0.3))
    )
    plan = dataclasses.replace(PLAN, inputs=np.zeros((100, 2)))
    for message in (tick, state, plan):
        assert len(encode(message)) < MAX_BYTES / 2


def test_the_checksum_is_the_crc_32_of_the_rest() -> None:
    payload = encode(PLAN)
    assert struct.unpack("<I", payload[:4])[0] == zlib.crc32(payload[4:])


def test_an_error_text_is_short_even_for_hostile_bytes() -> None:
    for body in ({"type": "x" * 10_000, "version": VERSION}, {"type": "plan", "version": "v" * 10_000}):
        with pytest.raises(WireError) as caught:
            decode(Plan, sealed(body))
        assert len(str(caught.value)) < 200
    long_key = body_of(PLAN) | {"k" * 10_000: 1}
    with pytest.raises(WireError) as caught:
        decode(Plan, sealed(long_key))
    assert len(str(caught.value)) < 300


def test_what_cannot_be_sent_is_a_type_error_of_the_sender() -> None:
    with pytest.raises(TypeError, match="cannot be sent"):
        encode(Request("fault", {"changes": object()}))
