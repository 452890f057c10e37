"""Laws of the state tables: complete, and from every state there is a way back."""

from collections.abc import Iterable, Mapping
from typing import Any

import pytest

from agents import states as agent_states
from world import presence
from world import states as world_states


def reachable(steps: Iterable[tuple[Any, Any]], start: Any) -> set[Any]:
    """States to which steps lead from a state."""
    steps, found, todo = list(steps), {start}, [start]
    while todo:
        here = todo.pop()
        new = {there for before, there in steps if before == here} - found
        found |= new
        todo += new
    return found


AGENT = [(state, after) for (state, _), (after, _) in agent_states.TABLE.items()]
AGENT.append((agent_states.State.NEW, agent_states.State.IDLE))  # the first Setup
WORLD = [(phase, after) for (phase, _), after in world_states.TABLE.items()]
PRESENCE = [(state, after) for (state, _), after in presence.TABLE.items()]


@pytest.mark.parametrize(
    ("steps", "states", "home"),
    [
        (AGENT, agent_states.State, agent_states.State.IDLE),
        (WORLD, world_states.Phase, world_states.Phase.HOLD),
        (PRESENCE, presence.Agent, presence.Agent.PRESENT),
    ],
)
def test_every_state_leads_back_and_can_be_reached(steps: Any, states: Any, home: Any) -> None:
    for state in states:
        assert home in reachable(steps, state), state
        first = agent_states.State.NEW if states is agent_states.State else home
        assert state in reachable(steps, first), state


def test_an_agent_knows_what_to_do_on_every_event_in_every_state() -> None:
    table: Mapping[Any, Any] = agent_states.TABLE
    assert set(table) == {(state, event) for state in agent_states.State for event in agent_states.Event}


def test_an_answer_is_given_from_every_state_once_everything_is_there() -> None:
    for state in agent_states.State:
        assert agent_states.TABLE[state, agent_states.Event.READY][1] is agent_states.Output.ANSWER
