"""The table of topics as the manual has it, made of network/topics.py."""

from network.control import OPERATIONS, QUESTIONS
from network.topics import ALIVE, QUESTION, ROOT, TOPICS, Topic


def table() -> str:
    """Markdown, a line per topic."""
    head = ["| key expression | message | from | rate |", "|---|---|---|---|"]
    return "\n".join([*head, *(_line(topic) for topic in TOPICS)]) + "\n"


def _line(topic: Topic) -> str:
    key = f"`{ROOT}/{{run}}/{topic.path}`"
    pace = topic.pace or f"{topic.rate:g} Hz"
    return f"| {key} | {_message(topic)} | {topic.sender} | {pace} |"


def _message(topic: Topic) -> str:
    if topic is ALIVE:
        return topic.carries
    if not topic.published:
        asked, *answers = (kind.__name__ for kind in topic.messages)
        names = [name for name in OPERATIONS if (name in QUESTIONS) == (topic is QUESTION)]
        return f"{topic.carries}: {asked} ({', '.join(names)}); answered by {' or '.join(answers)}"
    return f"{topic.messages[0].__name__}: {topic.carries}"
