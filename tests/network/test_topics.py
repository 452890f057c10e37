"""Laws of the table of topics: it covers every message and key, and the manual's table says what it says."""

import math
import typing
from typing import Any

import pytest

from docs import topics_table
from network import topics
from network.messages import Message
from network.topics import TOPICS, Topic


def test_every_message_has_a_topic() -> None:
    assert set(topics.MESSAGES.values()) == set(typing.get_args(Message))


def test_names_and_keys_are_distinct() -> None:
    assert len({topic.name for topic in TOPICS}) == len({topic.path for topic in TOPICS}) == len(TOPICS)


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_a_key_leads_back_to_its_topic(topic: Topic) -> None:
    key = topic.key("some-run", 12, "agent")
    assert topics.topic_of(key) is topic
    assert topics.robot_of(key) == (12 if topic.path.startswith("robot/") else None)


@pytest.mark.parametrize(
    "key", ["", "tick", "echelon/x", "echelon/x/ticks", "other/x/tick", "echelon/x/robot/1", "a/b/c"]
)
def test_another_key_has_no_topic(key: Any) -> None:
    assert topics.topic_of(key) is None


def test_a_sender_that_counts_as_gone_has_missed_several_messages() -> None:
    for topic in TOPICS:
        if topic.stale < math.inf:
            assert topic.stale > 2.0 * topic.interval


def test_the_manuals_table_has_every_topic_with_its_message() -> None:
    lines = topics_table.table().splitlines()[2:]
    assert len(lines) == len(TOPICS)
    for topic, line in zip(TOPICS, lines, strict=True):
        assert f"`echelon/{{run}}/{topic.path}`" in line
        assert all(kind.__name__ in line for kind in topic.messages)
