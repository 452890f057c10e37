"""Killing and restarting agents from the page, confirmed in a modal; robots that leave the ring and join it."""

from typing import Any

import viser

from dashboard.edits import Edit, on_edit
from dashboard.requests import RequestQueue
from network.control import Kill, Operation, Restart
from network.interventions import Join, Leave
from network.messages import State

_KILL = (
    "Its process is killed. The watchdog stops robot {robot} after 0.2 s, the robot downstream continues with the last "
    "plan it received, and the agent stays down until you press ↻ (restart)."
)
_RESTART = "Its process is killed, and a new one starts that knows nothing of the episode so far."


VERBS = ("kill", "restart", "leave", "join")
"""What can be done to a robot's part in the run."""


class AgentLifecycle:
    """Asks for confirmation before an agent is killed."""

    def __init__(self, requests: RequestQueue) -> None:
        self._requests = requests
        self._open: dict[int, Any] = {}
        self._state: State | None = None

    def draw(self, state: State) -> None:
        """Take over the newest state."""
        self._state = state

    def clicked(self, verb: str, robot: int, client: viser.ClientHandle) -> None:
        """A user clicked one of VERBS of a robot."""
        state = self._state
        if state is None or not 1 <= robot <= len(state.poses):
            return
        if verb in ("leave", "join"):  # nothing is lost by it
            self._requests.ask((Leave if verb == "leave" else Join)(robot=robot), client.client_id)
        elif verb == "kill":
            self._confirm(client, f"Kill agent {robot}?", _KILL.format(robot=robot), f"Kill {robot}", Kill(robot=robot))
        elif robot in state.dismissed:  # there is no process to lose
            self._requests.ask(Restart(robot=robot), client.client_id)
        else:
            self._confirm(client, f"Restart agent {robot}?", _RESTART, f"Restart {robot}", Restart(robot=robot))

    def _confirm(self, client: viser.ClientHandle, title: str, text: str, yes: str, operation: Operation) -> None:
        """Ask on this page only; a modal that is open there is replaced."""
        self._close(client.client_id)
        self._open[client.client_id] = modal = client.gui.add_modal(title)
        with modal:
            client.gui.add_markdown(text)
            confirm = client.gui.add_button(
                yes, color="red", icon=viser.Icon.SKULL if yes[0] == "K" else viser.Icon.REFRESH
            )
            cancel = client.gui.add_button("Cancel", color="gray")

        def confirmed(edit: Edit) -> None:
            self._close(edit.page)
            self._requests.ask(operation, edit.page)

        on_edit(confirm, confirmed)
        on_edit(cancel, lambda edit: self._close(edit.page))

    def _close(self, page: int) -> None:
        modal = self._open.pop(page, None)
        if modal is not None and not modal.closed:
            modal.close()
