"""Ending and starting agents from the page: asked twice, done by the run's launcher, shown as the world has it."""

from typing import Any

import viser

from dashboard.panels.requests import RequestQueue
from network.control import Kill, Operation, Restart
from network.messages import State

_KILL = (
    "Its process ends at once, without a goodbye. The watchdog stops robot {robot} after 0.2 s, the robot downstream "
    "goes on with the last plan it heard, and nothing comes back before you press **restart**."
)
_RESTART = "Its process ends without a goodbye, and a new one begins that knows nothing of the flight so far."


class AgentLifecycle:
    """Asks before an agent is ended."""

    def __init__(self, requests: RequestQueue) -> None:
        self._requests = requests
        self._open: dict[int, Any] = {}
        self._state: State | None = None

    def draw(self, state: State) -> None:
        """Take in what the world says."""
        self._state = state

    def pressed(self, verb: str, robot: int, client: viser.ClientHandle) -> None:
        """A person pressed "kill" or "restart" for a robot."""
        state = self._state
        if state is None or not 1 <= robot <= len(state.poses):
            return
        if verb == "kill":
            self._confirm(client, f"Kill agent {robot}?", _KILL.format(robot=robot), f"Kill {robot}", Kill(robot=robot))
        elif robot in state.dismissed:  # nothing is lost by starting it
            self._requests.ask(Restart(robot=robot), client.client_id)
        else:
            self._confirm(client, f"Restart agent {robot}?", _RESTART, f"Restart {robot}", Restart(robot=robot))

    def _confirm(self, client: viser.ClientHandle, title: str, text: str, yes: str, operation: Operation) -> None:
        """Ask on this page only; a question that stands open there is replaced."""
        self._close(client.client_id)
        self._open[client.client_id] = modal = client.gui.add_modal(title)
        with modal:
            client.gui.add_markdown(text)
            do = client.gui.add_button(yes, color="red", icon=viser.Icon.SKULL if yes[0] == "K" else viser.Icon.REFRESH)
            leave = client.gui.add_button("Leave it alone", color="gray")

        def done(event: viser.GuiEvent[Any]) -> None:
            self._close(client.client_id)
            if event.target is do:
                self._requests.ask(operation, client.client_id)

        do.on_click(done)
        leave.on_click(done)

    def _close(self, page: int) -> None:
        modal = self._open.pop(page, None)
        if modal is not None and not modal.closed:
            modal.close()
